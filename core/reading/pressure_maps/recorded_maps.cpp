#include "core/reading/pressure_maps/recorded_maps.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/frame/significance.hpp"
#include "core/reading/pressure_maps/taxel_sums.hpp"

namespace slipd {
namespace {

// The first map's slot, of kMaps: room for smaller forces, and for a force some times larger before maps are
// joined.
constexpr double kFirstSlot = 4;
// What no pressure under no force counts for, in frames; it is known.
constexpr double kFramesOfNone = 1000;

}  // namespace

RecordedMaps::RecordedMaps(std::size_t taxels, bool with_shear)
    : taxels_(taxels), channels_(with_shear ? 3 : 1), values_(kMaps * channels_ * taxels) {
  contact_.reserve(taxels);
  order_.reserve(kMaps);
}

void RecordedMaps::clear() noexcept {
  maps_.fill({});
  root_step_ = 0;
  order_.clear();
  contact_.clear();
}

std::size_t RecordedMaps::slot_of(double normal_n) const noexcept {
  if (!(root_step_ > 0)) return kMaps;
  const double slot = std::sqrt(normal_n) / root_step_;
  return slot < static_cast<double>(kMaps) ? static_cast<std::size_t>(slot) : kMaps;
}

double RecordedMaps::frames_like(double normal_n) const noexcept {
  const std::size_t slot = slot_of(normal_n);
  return slot < kMaps ? maps_[slot].frames : 0;
}

void RecordedMaps::add(const TaxelView& taxels, double normal_n) noexcept {
  const double root = std::sqrt(normal_n);
  contact_.clear();
  if (root_step_ <= 0) root_step_ = root / kFirstSlot;
  while (root >= static_cast<double>(kMaps) * root_step_) halve();
  const auto slot = static_cast<std::size_t>(root / root_step_);
  Map& map = maps_[slot];
  const bool fresh = map.frames <= 0;
  ++map.frames;
  map.version = ++versions_;
  const double part = 1 / map.frames;
  map.force_n += part * (normal_n - map.force_n);
  const std::array<const float*, 3> channels{taxels.normal_pa, taxels.shear_x_pa, taxels.shear_y_pa};
  for (std::size_t channel = 0; channel < channels_; ++channel) {
    const std::span<const float> values(channels[channel], taxels_);
    TaxelVector mean = taxel_vector(values_of(slot).subspan(channel * taxels_, taxels_));
    if (fresh)
      mean = taxel_vector(values);
    else
      mean += static_cast<float>(part) * (taxel_vector(values) - mean);
  }
  if (fresh) sort_out();
}

// Room for forces up to four times as large.
void RecordedMaps::halve() noexcept {
  for (std::size_t slot = 0; slot < kMaps / 2; ++slot) join(slot, 2 * slot, 2 * slot + 1);
  std::fill(maps_.begin() + kMaps / 2, maps_.end(), Map{});
  root_step_ *= 2;
  sort_out();
}

void RecordedMaps::join(std::size_t into, std::size_t first, std::size_t second) noexcept {
  const Map a = maps_[first], b = maps_[second];
  const double frames = a.frames + b.frames;
  maps_[into] = {};
  if (frames <= 0) return;
  const double share = b.frames / frames;
  maps_[into] = {
      .frames = frames, .force_n = (1 - share) * a.force_n + share * b.force_n, .version = ++versions_};
  const auto of_first = taxel_vector(values_of(first)), of_second = taxel_vector(values_of(second));
  TaxelVector joined = taxel_vector(values_of(into));
  joined = static_cast<float>(1 - share) * of_first + static_cast<float>(share) * of_second;
}

void RecordedMaps::sort_out() noexcept {
  order_.clear();
  for (std::size_t slot = 0; slot < kMaps; ++slot) {
    if (maps_[slot].frames > 0) order_.push_back(slot);
  }
}

RecordedMaps::Sum RecordedMaps::at(double normal_n) const noexcept {
  const double last_n = force_n(size() - 1), before_n = force_n(size() - 2);
  if (normal_n - last_n > last_n - before_n) {
    const double part = (normal_n - before_n) / (last_n - before_n);
    return {.map = {size() - 2, size() - 1}, .weight = {1 - part, part}};
  }
  // Point 0 is no force, point i map i - 1.
  const double root = std::sqrt(normal_n);
  const auto root_of = [this](std::size_t point) { return point > 0 ? std::sqrt(force_n(point - 1)) : 0; };
  std::size_t above = 1;
  while (above < size() && root_of(above) <= root) ++above;
  constexpr std::size_t kPoints = Sum::kOfOneForce;
  const std::size_t first = std::min(above < kPoints / 2 ? 0 : above - kPoints / 2, size() + 1 - kPoints);
  const double scale = root_of(first + kPoints - 1) - root_of(first);
  Eigen::Matrix<double, kPoints, 3> powers;
  Eigen::Matrix<double, kPoints, 1> frames_of;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const std::size_t point = first + i;
    const double x = (root_of(point) - root) / scale;
    const auto row = static_cast<Eigen::Index>(i);
    powers.row(row) << 1, x, x * x;
    frames_of[row] = point > 0 ? frames(point - 1) : kFramesOfNone;
  }
  const Eigen::Matrix<double, kPoints, 3> weighted = frames_of.asDiagonal() * powers;
  const Eigen::Matrix3d squares = powers.transpose().lazyProduct(weighted);
  const Eigen::Vector3d here = squares.inverse().col(0);
  Sum sum;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const std::size_t point = first + i;
    if (point > 0)
      sum.map[i] = point - 1, sum.weight[i] = weighted.row(static_cast<Eigen::Index>(i)).dot(here);
  }
  return sum;
}

RecordedMaps::Sum RecordedMaps::difference(const Sum& a, const Sum& b) noexcept {
  Sum out = a;
  for (std::size_t i = 0; i < Sum::kOfOneForce; ++i) {
    out.map[Sum::kOfOneForce + i] = b.map[i];
    out.weight[Sum::kOfOneForce + i] = -b.weight[i];
  }
  return out;
}

void RecordedMaps::find_contact(double noise_pa) noexcept {
  if (!contact_.empty() || order_.empty()) return;
  const std::span<const float> last = normal_of(order_[size() - 1]);
  const double least_pa = kClearSigmas * noise_pa / std::sqrt(frames(size() - 1));
  for (std::uint32_t i = 0; i < taxels_; ++i) {
    if (last[i] > least_pa) contact_.push_back(i);
  }
  for (std::size_t i = 0; i < size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const std::size_t one = order_[i], other = order_[j];
      products_[one][other] = products_[other][one] = product(normal_of(one), normal_of(other));
    }
  }
}

double RecordedMaps::product(std::span<const float> a, std::span<const float> b) const noexcept {
  float sum = 0;
#pragma omp simd reduction(+ : sum)
  for (std::size_t k = 0; k < contact_.size(); ++k) sum += a[contact_[k]] * b[contact_[k]];
  return sum;
}

RecordedMaps::PerMap RecordedMaps::products(std::span<const float> values) const noexcept {
  PerMap out{};
  for (std::size_t i = 0; i < size(); ++i) out[i] = product(values, normal_of(order_[i]));
  return out;
}

double RecordedMaps::product(const Sum& sum, const PerMap& products) noexcept {
  double out = 0;
  for (std::size_t i = 0; i < Sum::kTerms; ++i) out += sum.weight[i] * products[sum.map[i]];
  return out;
}

double RecordedMaps::product_pa2(const Sum& a, const Sum& b, double noise_pa) const noexcept {
  double product = 0;
  for (std::size_t i = 0; i < Sum::kTerms; ++i) {
    for (std::size_t j = 0; j < Sum::kTerms; ++j)
      product += a.weight[i] * b.weight[j] * products_[order_[a.map[i]]][order_[b.map[j]]];
  }
  return product - static_cast<double>(contact_.size()) * noise_pa * noise_pa * noise_share(a, b);
}

double RecordedMaps::noise_share(const Sum& a, const Sum& b) const noexcept {
  double share = 0;
  for (std::size_t i = 0; i < Sum::kTerms; ++i) {
    for (std::size_t j = 0; j < Sum::kTerms; ++j) {
      if (a.map[i] == b.map[j]) share += a.weight[i] * b.weight[j] / frames(a.map[i]);
    }
  }
  return share;
}

}  // namespace slipd
