// From what slipd says to slipd_estimate, and the rule that no old margin comes out. Any one thread.
#pragma once

#include <cstdint>

#include "board_layout/layout.hpp"
#include "clients/c/estimate_values.hpp"
#include "clients/c/slipd.h"

namespace slipd::client {

// CLOCK_MONOTONIC, ns.
std::int64_t monotonic_ns() noexcept;

// SLIPD_ALERT_… of a record; an alert that this library does not have is of a newer slipd: slip.
int alert_of(const board_layout::Record& record) noexcept;

// No estimate: everything unknown. `state`: SLIPD_STATE_STALE or SLIPD_STATE_DISCONNECTED.
void clear(slipd_estimate& estimate, const char* name, int state) noexcept;

// Of a record in shared memory. `now_ns`: CLOCK_MONOTONIC.
void fill(slipd_estimate& estimate, const char* name, const board_layout::Record& record, std::int64_t now_ns,
          double max_age_s) noexcept;

// Of an estimate or grasp on the socket. `read_ns`: when it was read, CLOCK_MONOTONIC.
void fill(slipd_estimate& estimate, const EstimateValues& values, std::int64_t read_ns,
          double max_age_s) noexcept;

// The alert that came last, as far as it still stands while no frames come. `estimate` was cleared.
void take_last_alert(int alert, int cause, slipd_estimate& estimate) noexcept;

}  // namespace slipd::client
