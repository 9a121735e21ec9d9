// The system's clocks as numbers, for messages. Any thread.
#pragma once

#include <time.h>

#include <cstdint>

namespace slipd::bridges {

// Reading of a clock of clock_gettime(2), ns.
inline std::int64_t clock_ns(clockid_t clock) noexcept {
  constexpr std::int64_t kNsPerSecond = 1'000'000'000;
  timespec now{};
  clock_gettime(clock, &now);
  return std::int64_t{now.tv_sec} * kNsPerSecond + now.tv_nsec;
}

// Since an unknown moment, steadily, ns: the clock of slipd_estimate::time_ns.
inline std::int64_t monotonic_ns() noexcept {
  return clock_ns(CLOCK_MONOTONIC);
}

// Since 1970-01-01 UTC, ns. It jumps when somebody sets the clock.
inline std::int64_t realtime_ns() noexcept {
  return clock_ns(CLOCK_REALTIME);
}

}  // namespace slipd::bridges
