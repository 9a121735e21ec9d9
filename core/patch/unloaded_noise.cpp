#include "core/patch/unloaded_noise.hpp"

#include <algorithm>
#include <cmath>

#include "core/frame/pause.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

double mean_of(double one, double other) noexcept {
  return (one + other) / 2;
}

}  // namespace

UnloadedNoise::UnloadedNoise(const TaxelLayout& layout, double unloaded_n,
                             const UnloadedNoiseOptions& options)
    : area_m2_(layout.area_m2()), unloaded_n_(unloaded_n), options_(options) {}

void UnloadedNoise::Means::move(const Means& to, double gain) noexcept {
  normal_pa2 += gain * (to.normal_pa2 - normal_pa2);
  shear_pa2 += gain * (to.shear_pa2 - shear_pa2);
  normal_n2 += gain * (to.normal_n2 - normal_n2);
  shear_n2 += gain * (to.shear_n2 - shear_n2);
  normal_n += gain * (to.normal_n - normal_n);
  shear_x_n += gain * (to.shear_x_n - shear_x_n);
  shear_y_n += gain * (to.shear_y_n - shear_y_n);
}

UnloadedNoise::Means UnloadedNoise::means_of(const Frame& frame) const noexcept {
  const std::size_t taxels = frame.normal_pa.size();
  Means means;
  double p = 0, x = 0, y = 0;
  for (std::size_t i = 0; i < taxels; ++i) {
    const auto normal = static_cast<double>(frame.normal_pa[i]);
    const auto shear_x = static_cast<double>(frame.shear_x_pa[i]);
    const auto shear_y = static_cast<double>(frame.shear_y_pa[i]);
    p += normal;
    x += shear_x;
    y += shear_y;
    means.normal_pa2 += normal * normal;
    means.shear_pa2 += mean_of(shear_x * shear_x, shear_y * shear_y);
  }
  means.normal_pa2 /= static_cast<double>(taxels);
  means.shear_pa2 /= static_cast<double>(taxels);
  means.normal_n = p * area_m2_;
  means.shear_x_n = x * area_m2_;
  means.shear_y_n = y * area_m2_;
  means.normal_n2 = means.normal_n * means.normal_n;
  means.shear_n2 = mean_of(means.shear_x_n * means.shear_x_n, means.shear_y_n * means.shear_y_n);
  return means;
}

void UnloadedNoise::update(const Frame& frame) noexcept {
  const auto block_ns = static_cast<std::int64_t>(kBlock_s * 1e9);
  if (frames_ > 0 && frame.time_ns - began_ns_ >= block_ns) finish_block();
  if (frames_ == 0) {
    began_ns_ = frame.time_ns;
    block_ = {};
  }
  block_.move(means_of(frame), 1.0 / ++frames_);
}

void UnloadedNoise::finish_block() noexcept {
  frames_ = 0;
  const bool unloaded = std::fabs(block_.normal_n) <= unloaded_n_ &&
                        norm(block_.shear_x_n, block_.shear_y_n) <= kShearOverNormal * unloaded_n_;
  if (has_waiting_ && unloaded) count(waiting_);
  waiting_ = block_;
  has_waiting_ = unloaded;
}

void UnloadedNoise::count(const Means& block) noexcept {
  ++blocks_;
  mean_.move(block, std::max(1.0 / blocks_, kBlock_s / kDrift_s));
  if (blocks_ < options_.min_blocks || !(mean_.normal_pa2 > 0)) return;
  noise_ = SensorNoise{.normal_pa = std::sqrt(mean_.normal_pa2),
                       .shear_pa = std::sqrt(mean_.shear_pa2),
                       .normal_n = std::sqrt(mean_.normal_n2),
                       .shear_n = std::sqrt(mean_.shear_n2)};
}

}  // namespace slipd
