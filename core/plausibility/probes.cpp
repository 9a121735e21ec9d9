#include "core/plausibility/probes.hpp"

#include <algorithm>
#include <bit>

namespace slipd {
namespace {

constexpr std::size_t kLeastOfRow = 2;
constexpr std::uint32_t kOdd = 0x9E3779B1U;  // of a multiplicative hash (Knuth)
constexpr std::uint64_t kPrime = 0x9E3779B97F4A7C15ULL;
constexpr std::size_t kStride = 7;  // columns from a row's first probe to the next row's

}  // namespace

Probes::Probes(const TaxelLayout& layout, std::size_t most) {
  const std::size_t size = layout.size();
  if (const auto& grid = layout.regular()) {
    const std::size_t of_row =
        size <= most ? grid->columns : std::clamp(most / grid->rows, kLeastOfRow, grid->columns);
    for (std::size_t row = 0; row < grid->rows; ++row) {
      for (std::size_t i = 0; i < of_row; ++i) {
        const std::size_t column =
            size <= most ? i : (i * grid->columns / of_row + row * kStride) % grid->columns;
        taxels_.push_back(static_cast<std::uint32_t>(row * grid->columns + column));
      }
      row_ends_.push_back(static_cast<std::uint32_t>(taxels_.size()));
    }
  } else {
    const std::size_t count = std::min(size, most);
    for (std::size_t i = 0; i < count; ++i) taxels_.push_back(static_cast<std::uint32_t>(i * size / count));
  }
  if (row_ends_.size() < 2) row_ends_.clear();
  rows_.resize(row_ends_.size());
  last_.resize(kChannels * taxels_.size());
  way_.resize(kChannels * taxels_.size());
  changed_.resize(taxels_.size());
  turned_.resize(taxels_.size());
}

ChannelChange Probes::compare(std::span<const float> values, std::size_t channel) noexcept {
  ChannelChange sums;
  const std::size_t count = taxels_.size();
  float* const last = &last_[channel * count];
  float* const way = &way_[channel * count];
  unsigned changed = 0, turned = 0, nonzero = 0;
  std::uint32_t fingerprint = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const float now = values[taxels_[i]], step = now - last[i];
    const bool moves = step != 0;
    const bool turns = step * way[i] < 0;
    changed_[i] = moves ? 1 : 0;
    turned_[i] = turns ? 1 : 0;
    way[i] = moves ? step : way[i];
    last[i] = now;
    changed += changed_[i];
    turned += turned_[i];
    nonzero += now != 0 ? 1U : 0U;
    fingerprint += std::bit_cast<std::uint32_t>(now) * (kOdd + 2 * static_cast<std::uint32_t>(i));
  }
  sums.change = {count, changed, turned};
  sums.nonzero_before = channels_[channel].nonzero;
  sums.nonzero = nonzero;
  fingerprint_ = fingerprint_ * kPrime + fingerprint;
  return sums;
}

// Before compare(), which replaces the last frame's values.
void Probes::compare_pattern(std::span<const float> normal_pa) noexcept {
  float square = 0, product = 0;
  for (std::size_t i = 0; i < taxels_.size(); ++i) {
    const float now = normal_pa[taxels_[i]];
    square += now * now;
    product += now * last_[i];
  }
  pattern_ = {square, pattern_.square_pa2, product};
}

void Probes::update(const Frame& frame) noexcept {
  const std::array<std::span<const float>, kChannels> values{frame.normal_pa, frame.shear_x_pa,
                                                             frame.shear_y_pa};
  std::fill(rows_.begin(), rows_.end(), GroupChange{});
  fingerprint_ = 0;
  compare_pattern(frame.normal_pa);
  for (std::size_t channel = 0; channel < kChannels; ++channel) {
    channels_[channel] = compare(values[channel], channel);
    std::uint32_t probe = 0;
    for (std::size_t row = 0; row < rows_.size(); ++row) {
      rows_[row].values += row_ends_[row] - probe;
      for (; probe < row_ends_[row]; ++probe) {
        rows_[row].changed += changed_[probe];
        rows_[row].turned += turned_[probe];
      }
    }
  }
}

}  // namespace slipd
