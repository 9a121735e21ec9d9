// Taxels that are compared from frame to frame: all of a small sensor, some of each row of a large one. That
// many are enough to tell what happens to a whole frame, a channel or a row, at a cost that hardly grows with
// the sensor. Estimate thread; nothing allocates after construction.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/plausibility/stillness.hpp"

namespace slipd {

inline constexpr std::size_t kChannels = 3;  // normal, shear x, shear y

// What one channel's probes did.
struct ChannelChange {
  GroupChange change;
  std::size_t nonzero = 0;         // probes that are not exactly 0
  std::size_t nonzero_before = 0;  // the same a frame ago
};

// The pressures of a frame beside those of the frame before.
struct PatternChange {
  double square_pa2 = 0;         // sum of squares
  double square_before_pa2 = 0;  // the same a frame ago
  double product_pa2 = 0;        // sum of products of both

  // 1 - cos^2 between both: 0 where one is a multiple of the other, 1 where they share no taxel.
  double unlikeness() const noexcept {
    const double squares = square_pa2 * square_before_pa2;
    return squares > 0 ? 1 - product_pa2 * product_pa2 / squares : 0;
  }
};

class Probes {
 public:
  // `most`: taxels that are compared, if the layout has more; at least two of each row of a grid.
  Probes(const TaxelLayout& layout, std::size_t most);

  // Reads one frame.
  void update(const Frame& frame) noexcept;

  std::size_t size() const noexcept { return taxels_.size(); }
  const std::array<ChannelChange, kChannels>& channels() const noexcept { return channels_; }
  const PatternChange& pattern() const noexcept { return pattern_; }
  // Of all values of this frame: equal for equal frames, and hardly for others.
  std::uint64_t fingerprint() const noexcept { return fingerprint_; }
  // Of all three channels of each row of a grid; none for other layouts.
  std::span<const GroupChange> rows() const noexcept { return rows_; }

 private:
  void compare_pattern(std::span<const float> normal_pa) noexcept;
  ChannelChange compare(std::span<const float> values, std::size_t channel) noexcept;

  std::vector<std::uint32_t> taxels_;    // row by row
  std::vector<std::uint32_t> row_ends_;  // places in taxels_; empty: no rows
  std::vector<float> last_, way_;        // each channel's values of the last frame, and their last change
  std::vector<std::uint8_t> changed_, turned_;  // of one channel
  std::array<ChannelChange, kChannels> channels_;
  std::vector<GroupChange> rows_;
  PatternChange pattern_;
  std::uint64_t fingerprint_ = 0;
};

}  // namespace slipd
