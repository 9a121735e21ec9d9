// What SLIPD_ALERT_… numbers mean, for libslipd and the bridges. Constants only: nothing of it is exported.
#pragma once

#include "clients/c/slipd.h"

namespace slipd::client {

// Whether it is an alert that somebody acts on.
constexpr bool is_raised(int alert) noexcept {
  return alert == SLIPD_ALERT_WARN || alert == SLIPD_ALERT_SLIP;
}

// What is known of an alert once its frames are too old: a raised one stands, none becomes unknown.
constexpr int without_frames(int alert) noexcept {
  return alert == SLIPD_ALERT_NONE ? int{SLIPD_ALERT_UNKNOWN} : alert;
}

}  // namespace slipd::client
