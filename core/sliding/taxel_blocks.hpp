// A sensor's frames as blocks of equal time: means of some tens of cells, each a few neighbouring taxels.
// What is looked for in the course of a grasp (core/sliding/sliding.hpp) is slow against a frame, and less
// noisy so.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/frame/pause.hpp"

namespace slipd {

// Checked with `slipd-bench`.
struct TaxelBlockOptions {
  // Cells along each side of a layout with more taxels than cells; 4 … 16. Too small: a movement within a
  // cell goes unseen. Too large: noise.
  std::size_t cells_per_side = 8;
  // Frames of a block that are looked at where cells have several taxels; 1 … 50. Too small: noise. Too
  // large: costs time.
  double pooled_frames = 4;
};

// Not thread-safe. Belongs to the estimate thread; allocates in its constructor only.
class TaxelBlocks {
 public:
  // Blocks that are kept; one more than the intervals of the longest window.
  static constexpr std::size_t kKept = 13;

  explicit TaxelBlocks(const TaxelLayout& layout, const TaxelBlockOptions& options = {});

  // Adds a frame of the layout's size. True if a block was completed: with the first frame after it, or, of a
  // sensor whose blocks are single frames, with that frame.
  bool add(const Frame& frame) noexcept;
  void forget() noexcept;

  // Blocks at hand, at most kKept.
  std::size_t size() const noexcept { return size_; }
  std::size_t cells() const noexcept { return cells_; }
  // The mean of each channel of the block that is `ago` blocks old, 0 for the newest; ago < size(). cells()
  // normal values, then as many along x, then along y; a cell's value is the sum of its taxels, in Pa or in
  // the sensor's counts.
  const float* block(std::size_t ago) const noexcept;
  // How many blocks last as long as so many of kBlock_s do; at least 2. A slow sensor's are longer.
  std::size_t blocks_in(std::size_t blocks) const noexcept;
  // Standard deviation of the newest block's values that is due to noise of single frames, as root mean
  // square over all channels: that of the quietest blocks so far. 0: not known yet.
  double noise() const noexcept;
  // Centres of cells, m.
  double x_m(std::size_t cell) const noexcept { return x_m_[cell]; }
  double y_m(std::size_t cell) const noexcept { return y_m_[cell]; }

 private:
  void pool(const Frame& frame) noexcept;
  void measure_noise() noexcept;
  void complete() noexcept;
  bool spans_block(std::int64_t passed_ns) const noexcept;

  TaxelBlockOptions options_;
  std::size_t taxels_, cells_;
  std::vector<std::uint16_t> cell_of_;  // of each taxel; empty: each is a cell of its own
  std::vector<double> x_m_, y_m_;
  std::vector<float> frame_, last_frame_;  // the frame's cells, and those of the frame before
  std::vector<double> sums_;               // of the block so far
  std::vector<float> blocks_;              // kKept blocks, a ring
  std::size_t size_ = 0, newest_ = 0;
  std::int64_t started_ns_ = 0, last_ns_ = 0, pooled_ns_ = 0;
  std::size_t frames_ = 0, differences_ = 0;
  double squares_ = 0;         // of differences of frames in the block so far
  double frame_variance_ = 0;  // of one frame, of the quietest block; 0: not known
  double step_ = 0;            // the smallest difference seen
  double block_frames_ = 1;    // in the newest block
  double spacing_s_ = 0;       // from the newest block's first frame to this one's; 0: not known
  bool has_last_ = false;
};

}  // namespace slipd
