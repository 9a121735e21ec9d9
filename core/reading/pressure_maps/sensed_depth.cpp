// Of SensedMaps: the maps, filtered and smoothed, and the depth that they show.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/frame/model_errors.hpp"
#include "core/reading/pressure_maps/sensed_maps.hpp"
#include "core/reading/pressure_maps/taxel_sums.hpp"

namespace slipd {
namespace {

// Maps of two forces are alike whose roots differ by less than this, over the root of the greatest one; 0.1 …
// 0.5. Too small: maps keep their noise. Too large: what a map has of its own is smoothed away. These two by
// `slipd-lab tradeoff --shapes`.
constexpr double kAlike = 0.3;
// Noise of a frame that the smoothing counts with, over its peak; 0.002 … 0.05. Too small: maps keep their
// noise. Too large: margins of a quiet sensor are not as good as they could be.
constexpr double kNoise = 0.01;

double covariance_of(double a, double b) noexcept {
  const double apart = (a - b) / kAlike;
  return std::exp(-0.5 * apart * apart);
}

}  // namespace

bool SensedMaps::ready(const RecordedMaps& maps) const noexcept {
  for (std::size_t map = 0; map < maps.size(); ++map) {
    if (version_[maps.slot(map)] != maps.version(map)) return false;
  }
  return true;
}

void SensedMaps::forget() noexcept {
  depth_.forget();
  last_filling_ = kNone;
  pulled_ = false;
}

void SensedMaps::prepare(const RecordedMaps& maps, std::size_t taxels, std::size_t filling) noexcept {
  if (filling != last_filling_ && maps.size() > 0) {
    find_depth(maps);
    last_filling_ = filling;
  }
  std::size_t most = std::max<std::size_t>(1, taxels / taxels_);
  for (std::size_t map = 0; map < maps.size() && most > 0; ++map) {
    const std::size_t slot = maps.slot(map);
    if (slot == filling || version_[slot] == maps.version(map)) continue;
    filter(maps, map);
    --most;
  }
}

void SensedMaps::filter(const RecordedMaps& maps, std::size_t map) noexcept {
  const std::size_t slot = maps.slot(map), n = taxels_;
  const std::span<float> by_x = sensed_of(slot, false), by_y = sensed_of(slot, true);
  ratio_.apply(maps.values(map, RecordedMaps::normal),
               {by_x.first(n), by_x.subspan(n, n), by_y.subspan(n, n), by_x.last(n), by_y.last(n)});
  std::copy_n(by_x.begin() + static_cast<std::ptrdiff_t>(n), n, by_y.begin());
  version_[slot] = maps.version(map);
  smoothed_ = 0;
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const std::size_t other = maps.slot(i);
    const std::span<const float> other_x = sensed_of(other, false), other_y = sensed_of(other, true);
    const auto fill = [&](ProductsOfSlots& out, std::size_t first, std::size_t count) {
      const auto product = [&](std::span<const float> a, std::span<const float> b) {
        return taxel_dot(a.subspan(first, count), b.subspan(first, count));
      };
      out.xx[slot][other] = out.xx[other][slot] = product(by_x, other_x);
      out.yy[slot][other] = out.yy[other][slot] = product(by_y, other_y);
      out.xy[slot][other] = product(by_x, other_y);
      out.xy[other][slot] = product(other_x, by_y);
    };
    fill(as_shear_, 0, 2 * n);
    fill(as_pressure_, 2 * n, n);
  }
}

// One step of Newton's method on the log of the depth, by the map of the greatest force.
void SensedMaps::find_depth(const RecordedMaps& maps) noexcept {
  if (!depth_.open()) return;
  smooth(maps);
  const Weights last = at(maps, maps.force_n(maps.size() - 1));
  const std::span<float> all(scratch_), map = all.first(taxels_), sensed = all.subspan(taxels_, 2 * taxels_);
  const std::span<float> left = std::span(read_pa_).first(2 * taxels_), x = left.first(taxels_),
                         y = left.last(taxels_);
  for (const std::span<float> values : {map, left}) std::fill(values.begin(), values.end(), 0.0F);
  add_maps(map, 1, maps, last, RecordedMaps::normal);
  add_maps(x, 1, maps, last, RecordedMaps::shear_x);
  add_maps(y, 1, maps, last, RecordedMaps::shear_y);
  const double sensed_pa2 = taxel_dot(left, left), noise_pa2 = 0.5 * (noise_of(x) + noise_of(y));
  ratio_.set_depth(filtered_log_);
  ratio_.press(map, sensed.first(taxels_), sensed.last(taxels_));
  taxel_vector(left) -= taxel_vector(sensed);
  // By a step towards the nominal depth, so that it is within reach.
  const double step = filtered_log_ > 0 ? -kDeeper : kDeeper;
  ratio_.set_depth(filtered_log_ + step);
  taxel_vector(sensed) *= -1;
  const std::span<float> other = std::span(pressure_pa_), rest = all.subspan(3 * taxels_, taxels_);
  ratio_.press(map, other, rest);
  taxel_vector(sensed.first(taxels_)) += taxel_vector(other);
  taxel_vector(sensed.last(taxels_)) += taxel_vector(rest);
  ratio_.set_depth(filtered_log_);
  const double squares = taxel_dot(sensed, sensed) / (step * step), product = taxel_dot(left, sensed) / step;
  if (!(squares > 0 && sensed_pa2 > 0)) return;
  const double off_pa2 =
      taxel_dot(left, left) - product * product / squares - 2 * static_cast<double>(taxels_) * noise_pa2;
  if (off_pa2 > kMostUnexplained * kMostUnexplained * sensed_pa2) return;
  const LogDepth shown{filtered_log_ + product / squares,
                       std::max(kUnevenShare, std::sqrt(noise_pa2 / squares))};
  depth_.forget();  // what smaller forces have shown is in these maps, too
  depth_.take(depth_.with(shown));
  const double log =
      std::clamp(depth_.now().mean, -ShearFromPressureFilter::kReach, ShearFromPressureFilter::kReach);
  if (std::fabs(log - filtered_log_) < kUnevenShare) return;
  filtered_log_ = log;
  ratio_.set_depth(log);
  version_.fill(0);
}

// Mixed second differences leave of what a skin has smoothed nearly nothing, and of noise all.
double SensedMaps::noise_of(std::span<const float> values) const noexcept {
  if (columns_ < 3 || rows_ < 3) return 0;
  double squares = 0;
  for (std::size_t row = 1; row + 1 < rows_; ++row) {
    const float* const middle = values.data() + row * columns_;
    const float* const below = middle - columns_;
    const float* const above = middle + columns_;
    const auto across = [&](std::size_t i) { return below[i] - 2 * middle[i] + above[i]; };
    float sum = 0;
    for (std::size_t i = 1; i + 1 < columns_; ++i) {
      const float mixed = across(i - 1) - 2 * across(i) + across(i + 1);
      sum += mixed * mixed;
    }
    squares += static_cast<double>(sum);
  }
  constexpr double kOfWhiteNoise = 36;
  return squares / (kOfWhiteNoise * static_cast<double>((columns_ - 2) * (rows_ - 2)));
}

void SensedMaps::gather(const ProductsOfSlots& from, const RecordedMaps& maps, Pulls& out) const noexcept {
  const auto size = static_cast<Eigen::Index>(maps.size());
  for (Square* of : {&out.xx, &out.xy, &out.yy}) of->setZero(size + 1, size + 1);
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j < size; ++j) {
      const std::size_t one = maps.slot(static_cast<std::size_t>(i)),
                        other = maps.slot(static_cast<std::size_t>(j));
      out.xx(i, j) = from.xx[one][other];
      out.xy(i, j) = 0.5 * (from.xy[one][other] + from.xy[other][one]);
      out.yy(i, j) = from.yy[one][other];
    }
  }
}

void SensedMaps::smooth(const RecordedMaps& maps) noexcept {
  if (maps.newest() == smoothed_) return;
  smoothed_ = maps.newest();
  const auto size = static_cast<Eigen::Index>(maps.size());
  const double last_n = maps.force_n(maps.size() - 1);
  roots_.setZero(size + 1);
  per_frames_.setZero(size + 1);
  for (Eigen::Index i = 0; i < size; ++i) {
    const auto map = static_cast<std::size_t>(i);
    roots_[i] = std::sqrt(maps.force_n(map) / last_n);
    per_frames_[i] = 1 / maps.frames(map);
  }
  gather(as_shear_, maps, sensed_as_shear_);
  gather(as_pressure_, maps, sensed_as_pressure_);
  Square covariance(size + 1, size + 1);
  for (Eigen::Index i = 0; i <= size; ++i) {
    for (Eigen::Index j = 0; j <= size; ++j) covariance(i, j) = covariance_of(roots_[i], roots_[j]);
    covariance(i, i) += kNoise * kNoise * (i < size ? per_frames_[i] : 1e-3);
  }
  inverse_.setIdentity(size + 1, size + 1);
  const Eigen::LLT<Eigen::Ref<Square>> solved(covariance);
  solved.solveInPlace(inverse_);
}

SensedMaps::Weights SensedMaps::at(const RecordedMaps& maps, double normal_n) const noexcept {
  const double root = std::sqrt(normal_n / maps.force_n(maps.size() - 1));
  Weights alike(roots_.size());
  for (Eigen::Index i = 0; i < roots_.size(); ++i) alike[i] = covariance_of(root, roots_[i]);
  return inverse_.lazyProduct(alike);
}

}  // namespace slipd
