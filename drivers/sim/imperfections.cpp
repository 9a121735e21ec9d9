#include "drivers/sim/imperfections.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace slipd::sim {
namespace {

enum Stream : std::uint64_t {
  noise_stream,
  loss_stream,
  delay_stream,
  gain_stream,
  drift_stream,
  dead_stream,
  zero_stream
};

float largest(std::span<const float> values) noexcept {
  float most = 0;
  for (const float v : values) most = std::max(most, std::fabs(v));
  return most;
}

// Draws exactly the given share of the taxels, so that sensors with few taxels have it, too.
std::vector<std::uint32_t> drawn(const RandomStream& draws, std::size_t taxels, double share) {
  std::vector<std::uint32_t> all(taxels);
  std::iota(all.begin(), all.end(), 0U);
  const auto count = static_cast<std::size_t>(std::llround(share * static_cast<double>(taxels)));
  for (std::size_t i = 0; i < count; ++i) {
    const auto other = i + static_cast<std::size_t>(draws.uniform(i) * static_cast<double>(taxels - i));
    std::swap(all[i], all[other]);
  }
  all.resize(count);
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace

Imperfections::Imperfections(const ImperfectionSettings& settings, std::size_t taxels)
    : settings_(settings),
      noise_(RandomStream(settings.seed).stream(noise_stream)),
      loss_(RandomStream(settings.seed).stream(loss_stream)),
      delay_(RandomStream(settings.seed).stream(delay_stream)),
      dead_(drawn(RandomStream(settings.seed).stream(dead_stream), taxels, settings.dead)) {
  if (settings.gain_spread > 0) {
    gain_.assign(taxels, 1.0F);
    RandomStream(settings.seed)
        .stream(gain_stream)
        .add_noise(gain_.data(), taxels, static_cast<float>(settings.gain_spread));
  }
  const auto each_channel = [&](Stream stream, double within) {
    std::vector<float> values(within > 0 ? 3 * taxels : 0);
    RandomStream(settings.seed)
        .stream(stream)
        .add_noise(values.data(), values.size(), static_cast<float>(within));
    return values;
  };
  zero_pa_ = each_channel(zero_stream, settings.zero_spread_pa);
  drift_pa_s_ = each_channel(drift_stream, settings.drift_pa_s);
}

void Imperfections::apply(FrameSlot& frame, std::uint64_t number, double elapsed_s) const noexcept {
  const std::size_t taxels = frame.normal_pa.size();
  std::span<float> const channels[] = {frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa};
  if (!gain_.empty()) {
    for (const auto& values : channels) {
      for (std::size_t i = 0; i < taxels; ++i) values[i] *= gain_[i];
    }
  }
  if (settings_.noise > 0) add_noise(frame, number);
  const auto add = [&](const std::vector<float>& off, float times) {
    const float* next = off.data();
    for (const auto& values : channels) {
      for (std::size_t i = 0; i < taxels; ++i) values[i] += times * next[i];
      next += taxels;
    }
  };
  if (!zero_pa_.empty()) add(zero_pa_, 1);
  if (!drift_pa_s_.empty()) add(drift_pa_s_, static_cast<float>(elapsed_s));
  for (const auto taxel : dead_) {
    for (const auto& values : channels) values[taxel] = 0;
  }
}

void Imperfections::add_noise(FrameSlot& frame, std::uint64_t number) const noexcept {
  const auto share = static_cast<float>(settings_.noise);
  const auto full = static_cast<float>(settings_.full_scale_pa);
  const bool relative = settings_.noise_kind == NoiseKind::relative;
  const float pressure = share * (relative ? largest(frame.normal_pa) : full);
  const float shear =
      share * (relative ? std::max(largest(frame.shear_x_pa), largest(frame.shear_y_pa)) : full);
  const RandomStream draws = noise_.stream(number);
  draws.stream(0).add_noise(frame.normal_pa.data(), frame.normal_pa.size(), pressure);
  draws.stream(1).add_noise(frame.shear_x_pa.data(), frame.shear_x_pa.size(), shear);
  draws.stream(2).add_noise(frame.shear_y_pa.data(), frame.shear_y_pa.size(), shear);
}

bool Imperfections::lost(std::uint64_t number) const noexcept {
  return loss_.uniform(number) < settings_.drop;
}

std::int64_t Imperfections::late_ns(std::uint64_t number) const noexcept {
  return static_cast<std::int64_t>(delay_.uniform(number) * settings_.late_ms * 1e6);
}

}  // namespace slipd::sim
