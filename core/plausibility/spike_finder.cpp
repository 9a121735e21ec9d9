#include "core/plausibility/spike_finder.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {
namespace {

// Taxels whose centres are this near are neighbours, diagonal ones included; in sides.
constexpr double kNeighbourSides = 1.5;

// What stands for a value that is not a number: beyond every full scale.
constexpr float kBeyondAll_pa = 1e30F;

float size_of(float value) noexcept {
  return std::isfinite(value) ? std::fabs(value) : kBeyondAll_pa;
}

}  // namespace

SpikeFinder::SpikeFinder(const TaxelLayout& layout, const PlausibilityLimits& limits,
                         const SpikeOptions& options)
    : layout_(layout),
      limits_(limits),
      options_(options),
      may_leave_(std::clamp<std::size_t>(layout.size() / options.one_in, 1, options.most)),
      normal_(layout.size()),
      shear_x_(layout.size()),
      shear_y_(layout.size()) {
  if (layout.size() < 2) may_leave_ = 0;
}

bool SpikeFinder::needs_look(const ContactPatch& patch) noexcept {
  const float peak = patch.frame_peak_pa;
  const float shear = std::max(patch.shear_x_extreme_pa, patch.shear_y_extreme_pa);
  const bool grown = peak > options_.grown_factor * last_peak_pa_ ||
                     (shear > options_.grown_factor * last_shear_pa_ && shear > peak);
  const bool beyond = peak > limits_.full_scale.normal_pa || -patch.frame_least_pa > peak ||
                      shear > std::min(limits_.full_scale.shear_x_pa, limits_.full_scale.shear_y_pa);
  return ++frames_ % options_.look_frames == 0 || found_ || !patch.finite || beyond || grown;
}

void SpikeFinder::copy(const Frame& frame) noexcept {
  std::copy(frame.normal_pa.begin(), frame.normal_pa.end(), normal_.begin());
  std::copy(frame.shear_x_pa.begin(), frame.shear_x_pa.end(), shear_x_.begin());
  std::copy(frame.shear_y_pa.begin(), frame.shear_y_pa.end(), shear_y_.begin());
}

std::uint32_t SpikeFinder::worst_normal() const noexcept {
  std::size_t worst = 0;
  for (std::size_t i = 1; i < normal_.size(); ++i) {
    if (size_of(normal_[i]) > size_of(normal_[worst])) worst = i;
  }
  return static_cast<std::uint32_t>(worst);
}

std::uint32_t SpikeFinder::worst_shear() const noexcept {
  const auto shear = [this](std::size_t i) { return std::max(size_of(shear_x_[i]), size_of(shear_y_[i])); };
  std::size_t worst = 0;
  for (std::size_t i = 1; i < shear_x_.size(); ++i) {
    if (shear(i) > shear(worst)) worst = i;
  }
  return static_cast<std::uint32_t>(worst);
}

bool SpikeFinder::beyond(std::uint32_t taxel) const noexcept {
  return size_of(normal_[taxel]) > limits_.full_scale.normal_pa ||
         size_of(shear_x_[taxel]) > limits_.full_scale.shear_x_pa ||
         size_of(shear_y_[taxel]) > limits_.full_scale.shear_y_pa;
}

SpikeFinder::Neighbourhood SpikeFinder::around(std::uint32_t taxel) const noexcept {
  Neighbourhood sums;
  float count = 0;
  const auto add = [&](std::size_t i) {
    sums.greatest_normal_pa = std::max(sums.greatest_normal_pa, size_of(normal_[i]));
    sums.greatest_shear_pa = std::max({sums.greatest_shear_pa, size_of(shear_x_[i]), size_of(shear_y_[i])});
    if (beyond(static_cast<std::uint32_t>(i))) return;  // it does not stand for another
    ++count;
    sums.mean_pa[0] += normal_[i];
    sums.mean_pa[1] += shear_x_[i];
    sums.mean_pa[2] += shear_y_[i];
  };
  if (const auto& grid = layout_.regular()) {
    const std::size_t column = taxel % grid->columns, row = taxel / grid->columns;
    for (std::size_t r = row - (row > 0 ? 1 : 0); r <= std::min(row + 1, grid->rows - 1); ++r) {
      for (std::size_t c = column - (column > 0 ? 1 : 0); c <= std::min(column + 1, grid->columns - 1); ++c) {
        if (r != row || c != column) add(r * grid->columns + c);
      }
    }
  } else {
    const double near_m = kNeighbourSides * layout_.side_m();
    for (std::size_t i = 0; i < layout_.size(); ++i) {
      const double x = layout_.x_m()[i] - layout_.x_m()[taxel], y = layout_.y_m()[i] - layout_.y_m()[taxel];
      if (i != taxel && x * x + y * y < near_m * near_m) add(i);
    }
  }
  for (float& mean : sums.mean_pa) mean /= std::max(count, 1.0F);
  return sums;
}

// Hertz: under this pressure on one taxel the stiffest contact would reach its neighbours.
bool SpikeFinder::spreads(double pressure_pa, double least_sides) const noexcept {
  return std::cbrt(limits_.least_m3_per_n * pressure_pa * layout_.area_m2()) > least_sides * layout_.side_m();
}

bool SpikeFinder::alone(std::uint32_t taxel, const Neighbourhood& around) const noexcept {
  const double normal_pa = size_of(normal_[taxel]);
  const bool jumped = touched_ && last_peak_pa_ > 0 && normal_pa > options_.jump_factor * last_peak_pa_;
  const double share = jumped ? options_.jumped_support_share : options_.support_share;
  if (around.greatest_normal_pa > share * normal_pa) return false;
  return spreads(normal_pa, jumped ? options_.least_jumped_radius_sides : options_.least_radius_sides);
}

void SpikeFinder::replace(std::uint32_t taxel, const Neighbourhood& around) noexcept {
  normal_[taxel] = around.mean_pa[0];
  shear_x_[taxel] = around.mean_pa[1];
  shear_y_[taxel] = around.mean_pa[2];
  left_out_n_ += std::fabs(around.mean_pa[0]) * layout_.area_m2();
}

std::size_t SpikeFinder::find(const Frame& frame, const ContactPatch& patch) noexcept {
  left_out_n_ = 0;
  std::size_t found = 0;
  if (needs_look(patch)) {
    copy(frame);
    for (; found <= may_leave_; ++found) {
      std::uint32_t taxel = worst_normal();
      Neighbourhood near = around(taxel);
      if (!beyond(taxel) && !alone(taxel, near)) {
        const float peak_pa = std::fabs(normal_[taxel]);
        taxel = worst_shear();
        near = around(taxel);
        const float shear_pa = std::max(size_of(shear_x_[taxel]), size_of(shear_y_[taxel]));
        last_shear_pa_ = shear_pa;
        last_peak_pa_ = peak_pa;
        const bool alone = shear_pa > options_.shear_factor * peak_pa &&
                           shear_pa > options_.shear_factor * near.greatest_shear_pa && patch.in_contact &&
                           spreads(shear_pa, options_.least_radius_sides);
        if (!beyond(taxel) && !alone) break;
      }
      replace(taxel, near);
    }
  } else {
    last_peak_pa_ = patch.frame_peak_pa;
    last_shear_pa_ = std::max(patch.shear_x_extreme_pa, patch.shear_y_extreme_pa);
  }
  found_ = found > 0;
  touched_ = patch.in_contact;
  return found;
}

Frame SpikeFinder::mended(const Frame& frame) const noexcept {
  return {frame.sequence, frame.time_ns, normal_, shear_x_, shear_y_, frame.zeroed};
}

}  // namespace slipd
