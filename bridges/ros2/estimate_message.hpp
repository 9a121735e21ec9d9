// From an estimate of libslipd to the message. Any thread.
#pragma once

#include <slipd.h>

#include "bridges/ros2/messages/messages.hpp"

namespace slipd::ros2 {

// A moment on both clocks.
struct Moment {
  std::int64_t monotonic_ns = 0;  // CLOCK_MONOTONIC
  std::int64_t realtime_ns = 0;   // CLOCK_REALTIME
  static Moment now() noexcept;
};

// The sample's time, ns since 1970: as slipd sent it, or by `now` where only shared memory has it.
std::int64_t realtime_of_sample(const slipd_estimate& from, const Moment& now) noexcept;

// The stamp is the sample's time; without a sample, that of `now`. The margin is a number in state ok only,
// and only if the estimate is still as young as its reader allowed.
void fill_message(const slipd_estimate& from, const Moment& now, SlipEstimate& to);

// There is no present estimate; `state`: SlipEstimate::kStale, kFault or kDisconnected. The stamp is that of
// `now`. Keeps an alert that was raised, which stands, and what the last sample's name, frame and number
// were.
void clear_message(std::uint8_t state, const Moment& now, SlipEstimate& to);

}  // namespace slipd::ros2
