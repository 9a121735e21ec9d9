// CLOCK_MONOTONIC in ns, and sleeping on it by absolute time, so that lateness does not accumulate. For
// drivers that pace themselves. Acquire thread.
#pragma once

#include <time.h>

#include <cerrno>
#include <cstdint>

namespace slipd {

inline std::int64_t monotonic_ns() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1000000000 + now.tv_nsec;
}

// Sleeps until `due_ns` or `give_up_ns`, whichever is first. True: `due_ns` has come.
inline bool sleep_until(std::int64_t due_ns, std::int64_t give_up_ns) noexcept {
  const std::int64_t wake_ns = due_ns < give_up_ns ? due_ns : give_up_ns;
  const timespec wake{static_cast<time_t>(wake_ns / 1000000000), static_cast<long>(wake_ns % 1000000000)};
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr) == EINTR) {
  }
  return due_ns <= give_up_ns;
}

}  // namespace slipd
