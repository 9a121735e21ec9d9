#include "core/health/probes.hpp"

#include <algorithm>
#include <cstring>

namespace slipd {
namespace {

constexpr std::size_t kLeastOfRow = 1;
constexpr std::size_t kStride = 7;  // columns from a row's first probe to the next row's
constexpr int kTurned = 16;         // bit from which on an activity counts turns
constexpr std::uint32_t kChanged = (1U << kTurned) - 1;
constexpr std::uint64_t kPrime = 0x9E3779B97F4A7C15ULL;  // of a multiplicative hash (Knuth)
constexpr int kRotation = 5;                             // of a hash by rotation
constexpr int kBits = 32;

// Vectors that every processor has (SSE2, NEON): the loops are too short to be built for each.
constexpr std::size_t kWide = 4;
using Floats4 = float __attribute__((vector_size(kWide * sizeof(float))));
using Ints4 = std::int32_t __attribute__((vector_size(kWide * sizeof(std::int32_t))));
using Bits4 = std::uint32_t __attribute__((vector_size(kWide * sizeof(std::uint32_t))));

template <class Vector, class Value>
Vector load_of(const Value* from) noexcept {
  Vector values;
  std::memcpy(&values, from, sizeof values);
  return values;
}

template <class Vector, class Value>
void store_to(Value* to, const Vector& values) noexcept {
  std::memcpy(to, &values, sizeof values);
}

// How many lanes of a sum of comparisons were true; each counts -1.
std::size_t lanes_of(const Ints4& counts) noexcept {
  return static_cast<std::size_t>(-(counts[0] + counts[1] + counts[2] + counts[3]));
}

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
    }
  } else {
    const std::size_t count = std::min(size, most);
    for (std::size_t i = 0; i < count; ++i) taxels_.push_back(static_cast<std::uint32_t>(i * size / count));
  }
  if (const auto& grid = layout.regular(); grid && grid->rows > 1 && grid->columns > 1) add_lines(*grid);
  padded_ = (taxels_.size() + kWide - 1) / kWide * kWide;
  now_.resize(kChannels * padded_);
  last_.resize(kChannels * padded_);
  way_.resize(kChannels * padded_);
  activity_.resize(padded_);
}

void Probes::add_lines(const TaxelLayout::Grid& grid) {
  const auto add = [&](const auto& is_in_line) {
    for (std::size_t i = 0; i < taxels_.size(); ++i) {
      if (is_in_line(taxels_[i])) line_probes_.push_back(static_cast<std::uint32_t>(i));
    }
    line_ends_.push_back(static_cast<std::uint32_t>(line_probes_.size()));
  };
  for (std::size_t row = 0; row < grid.rows; ++row)
    add([&](std::uint32_t taxel) { return taxel / grid.columns == row; });
  for (std::size_t column = 0; column < grid.columns; ++column)
    add([&](std::uint32_t taxel) { return taxel % grid.columns == column; });
}

void Probes::take(const Frame& frame) noexcept {
  float* const p = now_.data();
  float* const x = p + padded_;
  float* const y = x + padded_;
  for (std::size_t i = 0; i < taxels_.size(); ++i) {
    const std::uint32_t taxel = taxels_[i];
    p[i] = frame.normal_pa[taxel];
    x[i] = frame.shear_x_pa[taxel];
    y[i] = frame.shear_y_pa[taxel];
  }
}

// Before compare(), which replaces the last frame's values.
void Probes::compare_pattern() noexcept {
  Floats4 square{}, product{};
  for (std::size_t i = 0; i < padded_; i += kWide) {
    const auto now = load_of<Floats4>(&now_[i]);
    square += now * now;
    product += now * load_of<Floats4>(&last_[i]);
  }
  pattern_ = {square[0] + square[1] + square[2] + square[3], pattern_.square_pa2,
              product[0] + product[1] + product[2] + product[3]};
}

void Probes::compare(std::size_t channel) noexcept {
  const float* const values = &now_[channel * padded_];
  float* const last = &last_[channel * padded_];
  float* const way = &way_[channel * padded_];
  Ints4 changed{}, turned{}, nonzero{};
  Floats4 squares{};
  Bits4 hash{};
  for (std::size_t i = 0; i < padded_; i += kWide) {
    const auto now = load_of<Floats4>(values + i);
    const auto before = load_of<Floats4>(way + i);
    const Floats4 step = now - load_of<Floats4>(last + i);
    const Ints4 moves = step != 0;
    const Ints4 turns = step * before < 0;
    store_to(way + i, moves ? step : before);
    store_to(last + i, now);
    const Ints4 activity = load_of<Ints4>(&activity_[i]) - moves - (turns << kTurned);
    store_to(&activity_[i], activity);
    changed += moves;
    turned += turns;
    nonzero += now != 0;
    squares += step * step;
    hash = ((hash << kRotation) | (hash >> (kBits - kRotation))) ^ load_of<Bits4>(values + i);
  }
  ChannelChange& sums = channels_[channel];
  sums.change = {taxels_.size(), lanes_of(changed), lanes_of(turned)};
  sums.nonzero_before = sums.nonzero;
  sums.nonzero = lanes_of(nonzero);
  sums.step_square_pa2 = squares[0] + squares[1] + squares[2] + squares[3];
  for (std::size_t lane = 0; lane < kWide; ++lane) fingerprint_ = (fingerprint_ + hash[lane]) * kPrime;
}

GroupChange Probes::line(std::size_t line) const noexcept {
  GroupChange sums{.values = kChannels * probes_of(line).size()};
  for (const std::uint32_t probe : probes_of(line)) {
    sums.changed += activity_[probe] & kChanged;
    sums.turned += activity_[probe] >> kTurned;
  }
  return sums;
}

void Probes::update(const Frame& frame) noexcept {
  take(frame);
  compare_pattern();
  fingerprint_ = 0;
  std::fill(activity_.begin(), activity_.end(), 0U);
  for (std::size_t channel = 0; channel < kChannels; ++channel) compare(channel);
  Ints4 still{};
  const std::size_t whole = taxels_.size() / kWide * kWide;  // the others count as still
  for (std::size_t i = 0; i < whole; i += kWide) still |= load_of<Ints4>(&activity_[i]) == 0;
  any_still_ = whole < taxels_.size() || lanes_of(still) > 0;
}

}  // namespace slipd
