#include "grip/reading.hpp"

#include <cmath>

namespace slipd::grip {
namespace {

// What the sensors say of an object between the fingers.
std::optional<bool> contact_of(const slipd_estimate& now) noexcept {
  switch (now.state) {
    case SLIPD_STATE_NO_CONTACT:
      return false;
    case SLIPD_STATE_OK:
    case SLIPD_STATE_LEARNING:
    case SLIPD_STATE_OUT_OF_MODEL:
    case SLIPD_STATE_NO_SHEAR:
      return true;
    default:
      return std::nullopt;
  }
}

// Whether an alert of slip is of this frame. A raised one stands while slipd or a sensor is away, and, where
// there is no margin, for a second in which the object is seen to stand: that would raise the force to its
// limit.
bool slips_by_alert(const slipd_estimate& now, bool known) noexcept {
  const bool away = now.state == SLIPD_STATE_STALE || now.state == SLIPD_STATE_FAULT ||
                    now.state == SLIPD_STATE_DISCONNECTED;
  const bool stands = !known && now.sliding == SLIPD_SLIDING_NONE;
  return now.alert == SLIPD_ALERT_SLIP && !away && !stands;
}

}  // namespace

bool slides(const slipd_estimate& now) noexcept {
  return now.sliding == SLIPD_SLIDING_TRANSLATION || now.sliding == SLIPD_SLIDING_ROTATION;
}

Reading reading_of(const slipd_estimate& now, bool finger_slides) noexcept {
  const bool watched = now.alert != SLIPD_ALERT_UNKNOWN;
  const bool known = watched && std::isfinite(slipd_margin(&now));
  return {.known = known,
          .bounded = watched && std::isfinite(now.gamma_low) &&
                     (now.state == SLIPD_STATE_OK || now.state == SLIPD_STATE_LEARNING),
          .contact = contact_of(now),
          .slips = slips_by_alert(now, known) || slides(now) || finger_slides,
          .gamma = now.gamma,
          .gamma_low = now.gamma_low,
          .sigma = now.sigma,
          .normal_n = now.normal_n,
          .shear_n = now.shear_n,
          .increase_n = now.grip_increase_n,
          .time_to_slip_s = now.time_to_slip_s};
}

}  // namespace slipd::grip
