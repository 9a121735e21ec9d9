#include "grip/load_trend.hpp"

#include <algorithm>
#include <cmath>

namespace slipd::grip {

void LoadTrend::add(std::int64_t time_ns, double shear_n) {
  if (!std::isfinite(shear_n)) return samples_.clear();
  if (!samples_.empty() && time_ns <= samples_.back().time_ns) return;
  samples_.push_back({time_ns, shear_n});
  const auto oldest_ns = time_ns - static_cast<std::int64_t>(span_s_ * 1e9);
  while (samples_.front().time_ns < oldest_ns) samples_.pop_front();
}

// Least squares.
double LoadTrend::growth(double ahead_s) const {
  constexpr double kSigmas = 3, kLeastFree = 3;
  const double n = static_cast<double>(samples_.size()), free = n - 2;  // a line has two unknowns
  if (!(free >= kLeastFree) || !(samples_.back().shear_n > 0)) return 1;
  double t = 0, q = 0, tt = 0, tq = 0, qq = 0;
  for (const Sample& sample : samples_) {
    const double time_s = static_cast<double>(sample.time_ns - samples_.back().time_ns) * 1e-9;
    t += time_s / n;
    q += sample.shear_n / n;
    tt += time_s * time_s;
    tq += time_s * sample.shear_n;
    qq += sample.shear_n * sample.shear_n;
  }
  const double spread = tt - n * t * t, slope = (tq - n * t * q) / spread;
  const double scatter = std::max(0.0, qq - n * q * q - slope * slope * spread) / free;
  const double surely = slope - kSigmas * std::sqrt(scatter / spread);
  return 1 + std::max(0.0, surely) * ahead_s / samples_.back().shear_n;
}

}  // namespace slipd::grip
