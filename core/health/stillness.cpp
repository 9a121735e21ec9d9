#include "core/health/stillness.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {

bool Stillness::update(const GroupChange& now) noexcept {
  if (now.changed == 0) {
    ++run_;
    if (!noisy()) return false;
    // Laplace's rule of succession: so few frames do not show that a value changes always.
    const double unchanged = (1 + (1 - changing_) * frames_) / (2.0 + frames_);
    const double nats = -std::log(unchanged) * static_cast<double>(now.values) * run_;
    called_ = nats > kSureNats && run_ > kBeyondUsual * longest_;
    return called_;
  }
  const double gain = 1.0 / std::min<std::uint32_t>(frames_ + 1, kMemoryFrames);
  // A run that was not called out was chance, or the sensor's way.
  if (run_ > 0) {
    if (!called_) {
      longest_ = std::max(longest_, run_);
      changing_ *= std::pow(1 - gain, run_);
    }
    skip();
  }
  const double values = static_cast<double>(now.values), changed = static_cast<double>(now.changed);
  changing_ += gain * (changed / values - changing_);
  turning_ += gain * (static_cast<double>(now.turned) / changed - turning_);
  frames_ = std::min<std::uint32_t>(frames_ + 1, kMemoryFrames);
  return false;
}

}  // namespace slipd
