#include "clients/c/estimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <ctime>
#include <limits>
#include <optional>
#include <string_view>

#include "clients/c/alert.hpp"

namespace slipd::client {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

// By their numbers.
constexpr std::array<const char*, 9> kStates{"ok",       "no_contact", "learning", "out_of_model", "no_shear",
                                             "unzeroed", "stale",      "fault",    "disconnected"};
constexpr std::array<const char*, 4> kAlerts{"none", "warn", "slip", "unknown"};
constexpr std::array<const char*, 3> kCauses{"none", "margin", "sliding"};
constexpr std::array<const char*, 4> kSlidings{"none", "disturbed", "translation", "rotation"};

std::int64_t clock_ns(clockid_t clock) noexcept {
  timespec now{};
  clock_gettime(clock, &now);
  return std::int64_t{1'000'000'000} * now.tv_sec + now.tv_nsec;
}

void set_name(slipd_estimate& estimate, const char* name) noexcept {
  std::strncpy(estimate.name, name, sizeof estimate.name - 1);
}

// Takes away what must not be used once it is old. `since_ns`: CLOCK_MONOTONIC from which its age counts.
void judge_age(slipd_estimate& estimate, std::int64_t since_ns, std::int64_t now_ns,
               double max_age_s) noexcept {
  // A sample of the future is of another clock, as in a time namespace: nobody knows how old it is.
  const bool framed = estimate.time_ns != 0 && since_ns <= now_ns;
  estimate.age_s = framed ? 1e-9 * static_cast<double>(now_ns - since_ns) : kInfinite;
  if (max_age_s > 0) {
    const double until_ns = static_cast<double>(since_ns) + 1e9 * max_age_s;
    estimate.valid_until_ns = until_ns < 9e18 ? static_cast<std::int64_t>(until_ns) : kNever;
  }
  if (framed && estimate.age_s <= max_age_s) return;  // false, too, if max_age_s is NaN
  if (estimate.state != SLIPD_STATE_FAULT) estimate.state = SLIPD_STATE_STALE;
  estimate.alert = without_frames(estimate.alert);
  estimate.valid_until_ns = 0;
  estimate.gamma = estimate.sigma = estimate.gamma_low = kUnknown;
  estimate.time_to_slip_s = estimate.grip_increase_n = estimate.grip_increase_sigma_n = kUnknown;
  estimate.sliding = SLIPD_SLIDING_UNKNOWN;
  estimate.sliding_for_s = kUnknown;
}

// The cause that goes with this alert: none without one, and never none with one.
int cause_of(int alert, int cause) noexcept {
  if (!is_raised(alert)) return SLIPD_CAUSE_NONE;
  return cause == SLIPD_CAUSE_MARGIN || cause == SLIPD_CAUSE_SLIDING ? cause : int{SLIPD_CAUSE_UNKNOWN};
}

double known(const std::optional<double>& value, double factor = 1) noexcept {
  return value ? factor * *value : kUnknown;
}

template <std::size_t N>
int index_of(std::string_view name, const std::array<const char*, N>& names, int other) noexcept {
  const auto* const at = std::find(names.begin(), names.end(), name);
  return at == names.end() ? other : static_cast<int>(at - names.begin());
}

}  // namespace

std::int64_t monotonic_ns() noexcept {
  return clock_ns(CLOCK_MONOTONIC);
}

int alert_of(const board_layout::Record& record) noexcept {
  return record.alert <= SLIPD_ALERT_UNKNOWN ? record.alert : int{SLIPD_ALERT_SLIP};
}

void clear(slipd_estimate& estimate, const char* name, int state) noexcept {
  estimate = slipd_estimate{};
  set_name(estimate, name);
  estimate.state = state;
  estimate.alert = SLIPD_ALERT_UNKNOWN;
  estimate.sliding = SLIPD_SLIDING_UNKNOWN;
  estimate.event = SLIPD_EVENT_ESTIMATE;
  estimate.age_s = kInfinite;
  for (double* value :
       {&estimate.gamma, &estimate.sigma, &estimate.gamma_low, &estimate.friction, &estimate.friction_sigma,
        &estimate.normal_n, &estimate.shear_n, &estimate.torque_nm, &estimate.torque_sigma_nm,
        &estimate.center_x_m, &estimate.center_y_m, &estimate.radius_m, &estimate.time_to_slip_s,
        &estimate.grip_increase_n, &estimate.grip_increase_sigma_n, &estimate.sliding_for_s,
        &estimate.shear_x_n, &estimate.shear_y_n})
    *value = kUnknown;
}

void take_last_alert(int alert, int cause, slipd_estimate& estimate) noexcept {
  estimate.alert = without_frames(alert);
  estimate.alert_cause = cause_of(estimate.alert, cause);
}

void fill(slipd_estimate& estimate, const char* name, const board_layout::Record& record, std::int64_t now_ns,
          double max_age_s) noexcept {
  clear(estimate, name, SLIPD_STATE_STALE);
  // A number that this library does not have is of a newer slipd, and no margin.
  estimate.state = record.state <= SLIPD_STATE_FAULT ? record.state : int{SLIPD_STATE_FAULT};
  estimate.alert = alert_of(record);
  estimate.alert_cause = cause_of(estimate.alert, record.alert_cause);
  estimate.sliding = record.sliding;
  estimate.simulated = record.simulated;
  estimate.sequence = record.sequence;
  estimate.time_ns = record.time_ns;
  if (estimate.state == SLIPD_STATE_OK) estimate.gamma = record.gamma;
  estimate.sigma = record.sigma;
  estimate.gamma_low = record.gamma_low;
  estimate.friction = record.friction;
  estimate.friction_sigma = record.friction_sigma;
  estimate.normal_n = record.normal_n;
  estimate.shear_n = record.shear_n;
  estimate.torque_nm = record.torque_nm;
  estimate.torque_sigma_nm = record.torque_sigma_nm;
  estimate.center_x_m = record.center_x_m;
  estimate.center_y_m = record.center_y_m;
  estimate.radius_m = record.radius_m;
  estimate.time_to_slip_s = record.time_to_slip_s;
  estimate.grip_increase_n = record.grip_increase_n;
  estimate.grip_increase_sigma_n = record.grip_increase_sigma_n;
  estimate.sliding_for_s = record.sliding_for_s;
  // The clock of a recording may be ahead, so its age counts from the estimate at the latest.
  const std::int64_t since_ns = std::min(record.time_ns, record.published_ns);
  if (since_ns > now_ns) now_ns = monotonic_ns();  // published after the caller looked at the clock
  judge_age(estimate, since_ns, now_ns, max_age_s);
}

void fill(slipd_estimate& estimate, const EstimateValues& values, std::int64_t read_ns,
          double max_age_s) noexcept {
  clear(estimate, values.name.c_str(), SLIPD_STATE_STALE);
  // A name that this library does not have is of a newer slipd: no margin, and no alert that is missed.
  estimate.state = index_of(values.state, kStates, SLIPD_STATE_FAULT);
  estimate.alert = index_of(values.alert, kAlerts, SLIPD_ALERT_SLIP);
  estimate.alert_cause = cause_of(estimate.alert, index_of(values.alert_cause, kCauses, SLIPD_CAUSE_UNKNOWN));
  estimate.sliding = index_of(values.sliding, kSlidings, SLIPD_SLIDING_UNKNOWN);
  estimate.simulated = values.simulated ? 1 : 0;
  estimate.sequence = values.sequence;
  estimate.dropped = values.dropped;
  if (estimate.state == SLIPD_STATE_OK) estimate.gamma = known(values.gamma);
  estimate.sigma = known(values.sigma);
  estimate.gamma_low = known(values.gamma_low);
  estimate.friction = known(values.friction);
  estimate.friction_sigma = known(values.friction_sigma);
  estimate.normal_n = known(values.normal_n);
  estimate.shear_n = known(values.shear_n);
  estimate.shear_x_n = known(values.shear_x_n);
  estimate.shear_y_n = known(values.shear_y_n);
  estimate.torque_nm = known(values.torque_nmm, 1e-3);
  estimate.torque_sigma_nm = known(values.torque_sigma_nmm, 1e-3);
  estimate.center_x_m = known(values.center_x_mm, 1e-3);
  estimate.center_y_m = known(values.center_y_mm, 1e-3);
  estimate.radius_m = known(values.radius_mm, 1e-3);
  estimate.time_to_slip_s = known(values.time_to_slip_ms, 1e-3);
  estimate.grip_increase_n = known(values.grip_increase_n);
  estimate.grip_increase_sigma_n = known(values.grip_increase_sigma_n);
  estimate.sliding_for_s = known(values.sliding_for_ms, 1e-3);
  estimate.realtime_ns = values.time_ns;
  const std::int64_t now_ns = monotonic_ns();
  std::int64_t since_ns = now_ns;
  if (values.age_ms) {
    // Two clocks count: one may be set, the other does not see what waited in the socket.
    since_ns = read_ns - static_cast<std::int64_t>(1e6 * *values.age_ms);
    if (values.time_ns != 0)
      since_ns = std::min(since_ns, now_ns - (clock_ns(CLOCK_REALTIME) - values.time_ns));
    estimate.time_ns = since_ns;
  }
  judge_age(estimate, since_ns, now_ns, max_age_s);
}

}  // namespace slipd::client

double slipd_margin(const slipd_estimate* estimate) {
  using namespace slipd::client;
  const bool holds =
      estimate != nullptr && estimate->state == SLIPD_STATE_OK && monotonic_ns() <= estimate->valid_until_ns;
  return holds ? estimate->gamma : kUnknown;
}

const char* slipd_state_name(int state) {
  using slipd::client::kStates;
  return state >= 0 && state < static_cast<int>(kStates.size()) ? kStates[static_cast<std::size_t>(state)]
                                                                : "?";
}

const char* slipd_alert_name(int alert) {
  using slipd::client::kAlerts;
  return alert >= 0 && alert < static_cast<int>(kAlerts.size()) ? kAlerts[static_cast<std::size_t>(alert)]
                                                                : "?";
}
