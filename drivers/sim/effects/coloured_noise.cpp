#include "drivers/sim/effects/coloured_noise.hpp"

#include <cmath>
#include <utility>

namespace slipd::sim {

ColouredNoise::ColouredNoise(const ColouredNoiseSettings& settings, std::size_t taxels, std::uint64_t seed)
    : settings_(settings),
      draws_(seed),
      own_(settings.sigma_pa > 0 ? 3 * (taxels + 1) : 0),
      taxels_(taxels) {}

float ColouredNoise::draw(const RandomStream& draws, std::uint64_t i) noexcept {
  return draws.noise(3 * i) + draws.noise(3 * i + 1) + draws.noise(3 * i + 2);
}

void ColouredNoise::add(std::span<const std::span<float>> channels, std::uint64_t number,
                        double time_s) noexcept {
  if (own_.empty()) return;
  const double passed_s = time_s - std::exchange(last_s_, time_s);
  const bool first = !std::exchange(begun_, true);
  const double kept = first ? (settings_.from_zero ? 1 : 0) : std::exp(-passed_s / settings_.correlation_s);
  const auto old = static_cast<float>(kept), fresh = static_cast<float>(std::sqrt(1 - kept * kept));
  const RandomStream of_frame = draws_.stream(number);
  for (std::size_t i = 0; i < own_.size(); ++i) own_[i] = old * own_[i] + fresh * draw(of_frame, i);
  const auto shared = static_cast<float>(settings_.sigma_pa * std::sqrt(settings_.common));
  const auto single = static_cast<float>(settings_.sigma_pa * std::sqrt(1 - settings_.common));
  const float* next = own_.data();
  for (const auto& values : channels) {
    const float together = shared * next[taxels_];
    for (std::size_t i = 0; i < taxels_; ++i) values[i] += single * next[i] + together;
    next += taxels_ + 1;
  }
}

}  // namespace slipd::sim
