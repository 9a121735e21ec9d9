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
#include "core/health/stillness.hpp"

namespace slipd {

inline constexpr std::size_t kChannels = 3;  // normal, shear x, shear y

// What one channel's probes did.
struct ChannelChange {
  GroupChange change;
  std::size_t nonzero = 0;         // probes that are not exactly 0
  std::size_t nonzero_before = 0;  // the same a frame ago
  double step_square_pa2 = 0;      // sum of the squared changes
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
  // `most`: taxels that are compared, if the layout has more; at least one of each row of a grid.
  Probes(const TaxelLayout& layout, std::size_t most);

  // Reads one frame.
  void update(const Frame& frame) noexcept;

  std::size_t size() const noexcept { return taxels_.size(); }
  const std::array<ChannelChange, kChannels>& channels() const noexcept { return channels_; }
  const PatternChange& pattern() const noexcept { return pattern_; }
  // Of all values of this frame: equal for equal frames, and hardly for others.
  std::uint64_t fingerprint() const noexcept { return fingerprint_; }
  // Rows of a grid, then its columns; none for other layouts.
  std::size_t lines() const noexcept { return line_ends_.size(); }
  // Whether there is a probe of which no channel changed.
  bool any_still() const noexcept { return any_still_; }
  // Whether a value of the line changed, and what all three channels of its probes did.
  bool line_moved(std::size_t line) const noexcept {
    std::uint32_t any = 0;
    for (const std::uint32_t probe : probes_of(line)) any |= activity_[probe];
    return any != 0;
  }
  GroupChange line(std::size_t line) const noexcept;

 private:
  void take(const Frame& frame) noexcept;
  void compare_pattern() noexcept;
  void compare(std::size_t channel) noexcept;
  std::span<const std::uint32_t> probes_of(std::size_t line) const noexcept {
    const std::uint32_t begin = line > 0 ? line_ends_[line - 1] : 0;
    return std::span(line_probes_).subspan(begin, line_ends_[line] - begin);
  }
  void add_lines(const TaxelLayout::Grid& grid);

  std::vector<std::uint32_t> taxels_;                   // row by row
  std::vector<std::uint32_t> line_probes_, line_ends_;  // places in taxels_, line by line
  std::size_t padded_ = 0;  // probes of a channel, with zeros to a whole number of vectors
  // Each channel's values of this frame and of the last one, and their last change; channel by channel.
  std::vector<float> now_, last_, way_;
  // Of each probe, over all channels: values that changed, and kTurned times those that turned.
  std::vector<std::uint32_t> activity_;
  std::array<ChannelChange, kChannels> channels_;
  PatternChange pattern_;
  bool any_still_ = false;
  std::uint64_t fingerprint_ = 0;
};

}  // namespace slipd
