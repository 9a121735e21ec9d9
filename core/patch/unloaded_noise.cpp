#include "core/patch/unloaded_noise.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {
namespace {

double mean_of(double one, double other) noexcept {
  return (one + other) / 2;
}

}  // namespace

UnloadedNoise::UnloadedNoise(const TaxelLayout& layout, const UnloadedNoiseOptions& options)
    : area_m2_(layout.area_m2()), options_(options) {}

void UnloadedNoise::Squares::move(const Squares& to, double gain) noexcept {
  normal_pa2 += gain * (to.normal_pa2 - normal_pa2);
  shear_pa2 += gain * (to.shear_pa2 - shear_pa2);
  normal_n2 += gain * (to.normal_n2 - normal_n2);
  shear_n2 += gain * (to.shear_n2 - shear_n2);
}

UnloadedNoise::Squares UnloadedNoise::squares_of(const Frame& frame) const noexcept {
  const std::size_t taxels = frame.normal_pa.size();
  Squares squares;
  double p = 0, x = 0, y = 0;
  for (std::size_t i = 0; i < taxels; ++i) {
    const auto normal = static_cast<double>(frame.normal_pa[i]);
    const auto shear_x = static_cast<double>(frame.shear_x_pa[i]);
    const auto shear_y = static_cast<double>(frame.shear_y_pa[i]);
    p += normal;
    x += shear_x;
    y += shear_y;
    squares.normal_pa2 += normal * normal;
    squares.shear_pa2 += mean_of(shear_x * shear_x, shear_y * shear_y);
  }
  squares.normal_pa2 /= static_cast<double>(taxels);
  squares.shear_pa2 /= static_cast<double>(taxels);
  squares.normal_n2 = p * p * area_m2_ * area_m2_;
  squares.shear_n2 = mean_of(x * x, y * y) * area_m2_ * area_m2_;
  return squares;
}

void UnloadedNoise::update(const Frame& frame, bool unloaded) noexcept {
  if (!unloaded) {
    frames_ = 0;
    has_waiting_ = false;
    return;
  }
  const auto block_ns = static_cast<std::int64_t>(options_.block_s * 1e9);
  if (frames_ > 0 && frame.time_ns - began_ns_ >= block_ns) {
    if (has_waiting_) count(waiting_);
    waiting_ = block_;
    has_waiting_ = true;
    frames_ = 0;
  }
  if (frames_ == 0) {
    began_ns_ = frame.time_ns;
    block_ = {};
  }
  block_.move(squares_of(frame), 1.0 / ++frames_);
}

void UnloadedNoise::count(const Squares& block) noexcept {
  if (!std::isfinite(block.normal_n2) || !std::isfinite(block.shear_n2)) return;
  ++blocks_;
  mean_.move(block, std::max(1.0 / blocks_, options_.block_s / options_.follow_s));
  if (blocks_ < options_.min_blocks || !(mean_.normal_pa2 > 0)) return;
  noise_ = SensorNoise{.normal_pa = std::sqrt(mean_.normal_pa2),
                       .shear_pa = std::sqrt(mean_.shear_pa2),
                       .normal_n = std::sqrt(mean_.normal_n2),
                       .shear_n = std::sqrt(mean_.shear_n2)};
}

}  // namespace slipd
