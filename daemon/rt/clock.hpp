// Times for people: what the pipeline measures on CLOCK_MONOTONIC, said as CLOCK_REALTIME. Any thread.
#pragma once

#include <chrono>
#include <cstdint>

namespace slipd {

struct Now {
  std::int64_t monotonic_ns = 0;
  std::int64_t realtime_ns = 0;

  static Now read() noexcept {
    const auto ns = [](auto time) {
      return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
    };
    return {ns(std::chrono::steady_clock::now()), ns(std::chrono::system_clock::now())};
  }
  std::int64_t realtime_of(std::int64_t monotonic) const noexcept {
    return realtime_ns + (monotonic - monotonic_ns);
  }
};

}  // namespace slipd
