// Converts CLOCK_MONOTONIC, on which slipd measures, to CLOCK_REALTIME, which people and files use.
#pragma once

#include <chrono>
#include <cstdint>

namespace slipd {

// One moment on both clocks. Called from any thread.
struct Now {
  // ns, CLOCK_MONOTONIC.
  std::int64_t monotonic_ns = 0;
  // ns, CLOCK_REALTIME.
  std::int64_t realtime_ns = 0;

  // The present moment.
  static Now read() noexcept {
    const auto ns = [](auto time) {
      return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
    };
    return {ns(std::chrono::steady_clock::now()), ns(std::chrono::system_clock::now())};
  }
  // The CLOCK_REALTIME of a CLOCK_MONOTONIC time, by the present offset of the two clocks; both in ns.
  std::int64_t realtime_of(std::int64_t monotonic) const noexcept {
    return realtime_ns + (monotonic - monotonic_ns);
  }
};

}  // namespace slipd
