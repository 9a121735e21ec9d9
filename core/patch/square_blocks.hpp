// The taxels of a contact summed in square blocks: each is a larger taxel with less noise. Of a contact many
// taxels wide little is lost by that, and what is left is a tenth of the numbers. Estimate thread; nothing
// allocates after the constructor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/frame/layout.hpp"
#include "core/patch/patch.hpp"
#include "core/simd/taxel_runs.hpp"

namespace slipd {

class SquareBlocks {
 public:
  // `layout` is a grid. most_along_radius: the most that sum() is asked for; >= 1.
  SquareBlocks(const TaxelLayout& layout, double most_along_radius);

  // Whether a layout can be summed in blocks: it is a grid.
  static bool fits(const TaxelLayout& layout) noexcept { return layout.regular().has_value(); }

  // Sums the taxels of a frame in blocks as large as leave `along_radius` of them along the contact's radius,
  // or up to twice as many. `patch` is of the frame, in contact.
  void sum(const ContactPatch& patch, double along_radius) noexcept;

  // Taxels along a block's side, at least 1; a block has the square of it.
  std::size_t taxels_along() const noexcept { return along_; }
  // Number of blocks, at most most_along() squared.
  std::size_t size() const noexcept { return size_; }
  // The most rows and columns of blocks that a contact has.
  std::size_t most_along() const noexcept { return most_along_; }
  // Edges relative to the patch's centre, m. The columns of each row, from small y to large.
  double left_m() const noexcept { return left_m_; }
  double bottom_m() const noexcept { return bottom_m_; }
  double side_m() const noexcept { return side_m_; }
  std::span<const TaxelRun> rows() const noexcept { return rows_; }
  // Of each block, in order of rows: its middle relative to the patch's centre, m; mean pressure and mean
  // shear along the resultant, Pa.
  std::span<const double> x_m() const noexcept { return {x_m_.data(), size_}; }
  std::span<const double> y_m() const noexcept { return {y_m_.data(), size_}; }
  std::span<const double> normal_pa() const noexcept { return {normal_pa_.data(), size_}; }
  std::span<const double> shear_pa() const noexcept { return {shear_pa_.data(), size_}; }

  std::size_t memory_bytes() const noexcept {
    return sizeof(double) * 4 * x_m_.size() + sizeof(float) * 2 * row_normal_.size() +
           sizeof(TaxelRun) * rows_.capacity();
  }

 private:
  // Taxels of the grid along one axis that blocks cover.
  struct Span {
    std::size_t first = 0, blocks = 0;
  };
  Span cover(double center, double reach, std::size_t taxels) const noexcept;
  void sum_row(const ContactPatch& patch, std::size_t first_taxel, std::size_t blocks) noexcept;

  TaxelLayout::Grid grid_;
  double grid_left_m_, grid_bottom_m_;
  std::size_t most_along_, along_ = 1, size_ = 0;
  double left_m_ = 0, bottom_m_ = 0, side_m_ = 1;
  std::vector<TaxelRun> rows_;
  std::vector<double> x_m_, y_m_, normal_pa_, shear_pa_;
  std::vector<float> row_normal_, row_shear_;  // sums of a row of blocks, column of taxels by column
};

}  // namespace slipd
