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

// Whether the estimate is of a frame that is used.
bool is_of_now(const slipd_estimate& now) noexcept {
  return now.state != SLIPD_STATE_STALE && now.state != SLIPD_STATE_FAULT &&
         now.state != SLIPD_STATE_DISCONNECTED;
}

}  // namespace

bool slides(const slipd_estimate& now) noexcept {
  return now.sliding == SLIPD_SLIDING_TRANSLATION || now.sliding == SLIPD_SLIDING_ROTATION;
}

Reading reading_of(const slipd_estimate& now, bool finger_slides) noexcept {
  const bool watched = now.alert != SLIPD_ALERT_UNKNOWN;
  return {.known = watched && std::isfinite(slipd_margin(&now)),
          .bounded = watched && std::isfinite(now.gamma_low) &&
                     (now.state == SLIPD_STATE_OK || now.state == SLIPD_STATE_LEARNING),
          .contact = contact_of(now),
          .slips = (now.alert == SLIPD_ALERT_SLIP && is_of_now(now)) || slides(now) || finger_slides,
          .gamma = now.gamma,
          .gamma_low = now.gamma_low,
          .sigma = now.sigma,
          .normal_n = now.normal_n,
          .shear_n = now.shear_n,
          .increase_n = now.grip_increase_n,
          .time_to_slip_s = now.time_to_slip_s};
}

}  // namespace slipd::grip
