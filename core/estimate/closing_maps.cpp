#include "core/estimate/closing_maps.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace slipd {
namespace {

// The first map's slot, of kMaps: room for smaller forces, and for a force some times larger before maps are
// joined.
constexpr double kFirstSlot = 4;

Eigen::Map<const Eigen::VectorXf> vector_of(std::span<const float> values) noexcept {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

double dot(std::span<const float> a, std::span<const float> b) noexcept {
  return vector_of(a).dot(vector_of(b));
}

}  // namespace

ClosingMaps::ClosingMaps(std::size_t taxels, bool with_shear)
    : taxels_(taxels), channels_(with_shear ? 3 : 1), values_(kMaps * channels_ * taxels) {}

void ClosingMaps::clear() noexcept {
  maps_.fill({});
  root_step_ = 0;
  size_ = 0;
}

std::size_t ClosingMaps::slot_of(double normal_n) const noexcept {
  const double slot = root_step_ > 0 ? std::sqrt(normal_n) / root_step_ : kMaps;
  return slot < kMaps ? static_cast<std::size_t>(slot) : kMaps;
}

double ClosingMaps::frames_like(double normal_n) const noexcept {
  const std::size_t slot = slot_of(normal_n);
  return slot < kMaps ? maps_[slot].frames : 0;
}

void ClosingMaps::add(const TaxelView& taxels, double normal_n) noexcept {
  const double root = std::sqrt(normal_n);
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
    Eigen::Map<Eigen::VectorXf> mean(values_of(slot).data() + channel * taxels_,
                                     static_cast<Eigen::Index>(taxels_));
    if (fresh)
      mean = vector_of(values);
    else
      mean += static_cast<float>(part) * (vector_of(values) - mean);
  }
  if (fresh) sort_out();
  for (std::size_t i = 0; i < size_; ++i) {
    const std::size_t other = order_[i];
    products_[slot][other] = products_[other][slot] = dot(normal_of(slot), normal_of(other));
  }
}

// Room for forces up to four times as large.
void ClosingMaps::halve() noexcept {
  for (std::size_t slot = 0; slot < kMaps / 2; ++slot) join(slot, 2 * slot, 2 * slot + 1);
  std::fill(maps_.begin() + kMaps / 2, maps_.end(), Map{});
  root_step_ *= 2;
  sort_out();
}

// The products of a mean are means of products: none is computed anew.
void ClosingMaps::join(std::size_t into, std::size_t first, std::size_t second) noexcept {
  const Map a = maps_[first], b = maps_[second];
  const double frames = a.frames + b.frames;
  maps_[into] = {};
  if (frames <= 0) return;
  const double share = b.frames / frames;
  maps_[into] = {
      .frames = frames, .force_n = (1 - share) * a.force_n + share * b.force_n, .version = ++versions_};
  const auto of_first = vector_of(values_of(first)), of_second = vector_of(values_of(second));
  Eigen::Map<Eigen::VectorXf> joined(values_of(into).data(), static_cast<Eigen::Index>(channels_ * taxels_));
  joined = static_cast<float>(1 - share) * of_first + static_cast<float>(share) * of_second;
  const auto mixed = [share](double x, double y) { return (1 - share) * x + share * y; };
  PerMap row{};
  for (std::size_t i = 0; i < kMaps; ++i) row[i] = mixed(products_[first][i], products_[second][i]);
  const double square = mixed(row[first], row[second]);
  for (std::size_t i = 0; i < kMaps; ++i) products_[into][i] = products_[i][into] = row[i];
  products_[into][into] = square;
}

void ClosingMaps::sort_out() noexcept {
  size_ = 0;
  for (std::size_t slot = 0; slot < kMaps; ++slot) {
    if (maps_[slot].frames > 0) order_[size_++] = slot;
  }
}

ClosingMaps::Sum ClosingMaps::at(double normal_n) const noexcept {
  std::size_t above = 0;
  while (above + 1 < size_ && force_n(above) <= normal_n) ++above;
  if (above == 0) return {.map = {0}, .weight = {normal_n / force_n(0)}};
  const double below_n = force_n(above - 1);
  const double part = (normal_n - below_n) / (force_n(above) - below_n);
  return {.map = {above - 1, above}, .weight = {1 - part, part}};
}

ClosingMaps::Sum ClosingMaps::difference(const Sum& a, const Sum& b) noexcept {
  return {.map = {a.map[0], a.map[1], b.map[0], b.map[1]},
          .weight = {a.weight[0], a.weight[1], -b.weight[0], -b.weight[1]}};
}

ClosingMaps::PerMap ClosingMaps::products(std::span<const float> values) const noexcept {
  PerMap out{};
  for (std::size_t i = 0; i < size_; ++i) out[i] = dot(values, normal_of(order_[i]));
  return out;
}

double ClosingMaps::product(const Sum& sum, const PerMap& products) noexcept {
  double out = 0;
  for (std::size_t i = 0; i < Sum::kTerms; ++i) out += sum.weight[i] * products[sum.map[i]];
  return out;
}

double ClosingMaps::product_pa2(const Sum& a, const Sum& b, double noise_pa) const noexcept {
  double product = 0;
  for (std::size_t i = 0; i < Sum::kTerms; ++i) {
    for (std::size_t j = 0; j < Sum::kTerms; ++j)
      product += a.weight[i] * b.weight[j] * products_[order_[a.map[i]]][order_[b.map[j]]];
  }
  return product - static_cast<double>(taxels_) * noise_pa * noise_pa * noise_share(a, b);
}

double ClosingMaps::noise_share(const Sum& a, const Sum& b) const noexcept {
  double share = 0;
  for (std::size_t i = 0; i < Sum::kTerms; ++i) {
    for (std::size_t j = 0; j < Sum::kTerms; ++j) {
      if (a.map[i] == b.map[j]) share += a.weight[i] * b.weight[j] / frames(a.map[i]);
    }
  }
  return share;
}

}  // namespace slipd
