// How long an object's sliding has been what it is. Estimate thread.
#pragma once

#include <cstdint>
#include <optional>

#include "core/sliding/sliding.hpp"

namespace slipd {

class SlidingTime {
 public:
  // In order of time, ns. Returns s, >= 0; none where nobody can tell whether it slides.
  std::optional<double> update(std::optional<Sliding> sliding, std::int64_t time_ns) noexcept {
    constexpr double kSecondsPerNs = 1e-9;
    if (sliding != last_) since_ns_ = time_ns;
    last_ = sliding;
    if (!sliding) return {};
    return static_cast<double>(time_ns - since_ns_) * kSecondsPerNs;
  }

 private:
  std::optional<Sliding> last_;
  std::int64_t since_ns_ = 0;
};

}  // namespace slipd
