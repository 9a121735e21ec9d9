#include "core/health/spike_finder.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/contact/scene.hpp"
#include "core/frame/few_taxels.hpp"
#include "core/health/usual.hpp"

namespace slipd {
namespace {

// Taxels whose centres are this near are neighbours, diagonal ones included; in sides.
constexpr double kNeighbourSides = 1.5;

// What stands for a value that is not a number: beyond every full scale.
constexpr float kBeyondAllPa = 1e30F;

// Ordered as magnitudes are, what is not a number last.
std::uint32_t magnitude_bits(float value) noexcept {
  constexpr std::uint32_t kWithoutSign = 0x7FFFFFFF;
  return std::bit_cast<std::uint32_t>(value) & kWithoutSign;
}

float size_of(float value) noexcept {
  return std::isfinite(value) ? std::fabs(value) : kBeyondAllPa;
}

}  // namespace

SpikeFinder::SpikeFinder(const TaxelLayout& layout, const PlausibilityLimits& limits,
                         const SpikeOptions& options)
    : layout_(layout),
      limits_(limits),
      options_(options),
      may_leave_(layout.size() < kLeastTaxels ? 1 : kBadTaxels),
      normal_(layout.size()),
      shear_x_(layout.size()),
      shear_y_(layout.size()) {
  if (layout.size() < 2) may_leave_ = 0;
}

SpikeFinder::Look SpikeFinder::needed(const ContactPatch& patch) noexcept {
  const float peak = patch.frame_peak_pa;
  const float shear = std::max(patch.shear_x_extreme_pa, patch.shear_y_extreme_pa);
  // Noise by itself reaches about as far below zero as above.
  const double least_share = patch.in_contact ? 1 : kBeyondUsual;
  const bool beyond = peak > limits_.full_scale.normal_pa || -patch.frame_least_pa > least_share * peak ||
                      shear > std::min(limits_.full_scale.shear_x_pa, limits_.full_scale.shear_y_pa);
  const bool noisier = patch.noise_shear_pa > options_.grown_factor * last_noise_pa_;
  last_noise_pa_ = patch.noise_shear_pa;
  if (++frames_ % (learning_frames() * learning_frames()) == 0 || found_ || !patch.finite || beyond ||
      noisier)
    return Look::at_all;
  const bool grown = peak > options_.grown_factor * last_peak_pa_ || shear > kBeyondUsual * last_shear_pa_ ||
                     (shear > options_.grown_factor * last_shear_pa_ && shear > peak);
  return frames_ % learning_frames() == 0 || grown ? Look::at_peak : Look::none;
}

bool SpikeFinder::peak_stands_alone(const Frame& frame, const ContactPatch& patch) const noexcept {
  const Values values{frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa};
  const float peak_pa = patch.frame_peak_pa;
  const auto peak = std::find(frame.normal_pa.begin(), frame.normal_pa.end(), peak_pa);
  if (peak == frame.normal_pa.end()) return false;  // nothing is above 0
  if (alone(peak_pa, around(values, static_cast<std::uint32_t>(peak - frame.normal_pa.begin())))) return true;
  const float shear_pa = std::max(patch.shear_x_extreme_pa, patch.shear_y_extreme_pa);
  if (shear_pa <= peak_pa && shear_pa <= kBeyondUsual * last_shear_pa_) return false;
  bool found = false;
  patch.for_each_inside([&](std::uint32_t i) {
    const bool here = std::max(size_of(frame.shear_x_pa[i]), size_of(frame.shear_y_pa[i])) == shear_pa;
    found = found || (here && shear_alone(shear_pa, size_of(frame.normal_pa[i]), around(values, i)));
  });
  return found;
}

void SpikeFinder::copy(const Frame& frame) noexcept {
  std::copy(frame.normal_pa.begin(), frame.normal_pa.end(), normal_.begin());
  std::copy(frame.shear_x_pa.begin(), frame.shear_x_pa.end(), shear_x_.begin());
  std::copy(frame.shear_y_pa.begin(), frame.shear_y_pa.end(), shear_y_.begin());
}

std::uint32_t SpikeFinder::worst_normal() const noexcept {
  std::size_t worst = 0;
  std::uint32_t most = 0;
  for (std::size_t i = 0; i < normal_.size(); ++i) {
    const std::uint32_t size = magnitude_bits(normal_[i]);
    if (size > most) {
      most = size;
      worst = i;
    }
  }
  return static_cast<std::uint32_t>(worst);
}

std::uint32_t SpikeFinder::worst_shear() const noexcept {
  std::size_t worst = 0;
  std::uint32_t most = 0;
  for (std::size_t i = 0; i < shear_x_.size(); ++i) {
    const std::uint32_t size = std::max(magnitude_bits(shear_x_[i]), magnitude_bits(shear_y_[i]));
    if (size > most) {
      most = size;
      worst = i;
    }
  }
  return static_cast<std::uint32_t>(worst);
}

bool SpikeFinder::beyond(const Values& values, std::size_t taxel) const noexcept {
  return size_of(values.normal_pa[taxel]) > limits_.full_scale.normal_pa ||
         size_of(values.shear_x_pa[taxel]) > limits_.full_scale.shear_x_pa ||
         size_of(values.shear_y_pa[taxel]) > limits_.full_scale.shear_y_pa;
}

SpikeFinder::Neighbourhood SpikeFinder::around(const Values& values, std::uint32_t taxel) const noexcept {
  Neighbourhood sums;
  float count = 0;
  const auto add = [&](std::size_t i) {
    sums.greatest_normal_pa = std::max(sums.greatest_normal_pa, size_of(values.normal_pa[i]));
    sums.greatest_shear_pa =
        std::max({sums.greatest_shear_pa, size_of(values.shear_x_pa[i]), size_of(values.shear_y_pa[i])});
    if (beyond(values, i)) return;  // it does not stand for another
    ++count;
    sums.mean_pa[0] += values.normal_pa[i];
    sums.mean_pa[1] += values.shear_x_pa[i];
    sums.mean_pa[2] += values.shear_y_pa[i];
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

// Hertz: under this pressure on one taxel the stiffest contact would reach its neighbours. A pressure that
// jumped beyond kBeyondUsual is evidence by itself: that contact may be as much smaller.
bool SpikeFinder::spreads(double pressure_pa, double last_pa) const noexcept {
  const bool jumped = touched_ && last_pa > 0 && pressure_pa > kBeyondUsual * last_pa;
  const double least_sides = jumped ? kResolvedSides / kBeyondUsual : kResolvedSides;
  return std::cbrt(limits_.least_m3_per_n * pressure_pa * layout_.area_m2()) > least_sides * layout_.side_m();
}

bool SpikeFinder::alone(double normal_pa, const Neighbourhood& around) const noexcept {
  if (around.greatest_normal_pa > options_.support_share * normal_pa) return false;
  return spreads(normal_pa, last_peak_pa_);
}

bool SpikeFinder::shear_alone(double shear_pa, double normal_pa, const Neighbourhood& around) const noexcept {
  return shear_pa > kMostFriction * normal_pa &&
         around.greatest_shear_pa < options_.support_share * shear_pa && spreads(shear_pa, last_shear_pa_);
}

void SpikeFinder::replace(std::uint32_t taxel, const Neighbourhood& around) noexcept {
  normal_[taxel] = around.mean_pa[0];
  shear_x_[taxel] = around.mean_pa[1];
  shear_y_[taxel] = around.mean_pa[2];
  left_out_n_ += std::fabs(around.mean_pa[0]) * layout_.area_m2();
}

// Replaces the worst taxel until none stands alone.
std::size_t SpikeFinder::replace_all(const Frame& frame, const ContactPatch& patch) noexcept {
  copy(frame);
  std::size_t found = 0;
  for (; found <= may_leave_; ++found) {
    std::uint32_t taxel = worst_normal();
    Neighbourhood near = around(own(), taxel);
    if (!beyond(own(), taxel) && !alone(size_of(normal_[taxel]), near)) {
      const float peak_pa = size_of(normal_[taxel]);
      taxel = worst_shear();
      near = around(own(), taxel);
      const float shear_pa = std::max(size_of(shear_x_[taxel]), size_of(shear_y_[taxel]));
      if (!beyond(own(), taxel) &&
          !(patch.in_contact && shear_alone(shear_pa, size_of(normal_[taxel]), near))) {
        last_peak_pa_ = peak_pa;
        last_shear_pa_ = shear_pa;
        break;
      }
    }
    replace(taxel, near);
  }
  return found;
}

std::size_t SpikeFinder::find(const Frame& frame, const ContactPatch& patch) noexcept {
  left_out_n_ = 0;
  std::size_t found = 0;
  const Look look = needed(patch);
  if (look == Look::at_all || (look == Look::at_peak && peak_stands_alone(frame, patch))) {
    found = replace_all(frame, patch);
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
