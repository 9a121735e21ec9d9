#include "core/patch/square_blocks.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {

namespace {
const PatchOptions kPatch;  // blocks reach as far as the disc of its forces does
}

SquareBlocks::SquareBlocks(const TaxelLayout& layout, double most_along_radius)
    : grid_(*layout.regular()),
      grid_left_m_(layout.x_m().front() - 0.5 * grid_.pitch_m),
      grid_bottom_m_(layout.y_m().front() - 0.5 * grid_.pitch_m) {
  // Of single taxels a contact just too small for blocks of four has most.
  const double radius = 2 * most_along_radius * kPatch.reach_factor + kHalfDiagonal;
  most_along_ =
      std::min(std::max(grid_.columns, grid_.rows), static_cast<std::size_t>(std::ceil(2 * radius)) + 2);
  rows_.reserve(most_along_);
  for (auto* list : {&x_m_, &y_m_, &normal_pa_, &shear_pa_}) list->resize(most_along_ * most_along_);
  for (auto* list : {&row_normal_, &row_shear_}) list->resize(grid_.columns);
}

// As many blocks as reach to both ends, about the contact if the grid's edges leave room.
SquareBlocks::Span SquareBlocks::cover(double center, double reach, std::size_t taxels) const noexcept {
  const auto most = static_cast<double>(taxels);
  const auto low = static_cast<std::size_t>(std::clamp(std::floor(center - reach), 0.0, most)),
             high = static_cast<std::size_t>(std::clamp(std::ceil(center + reach), 0.0, most));
  const std::size_t blocks = std::min({(high - low + along_ - 1) / along_, taxels / along_, most_along_});
  const std::size_t covered = blocks * along_, beyond = covered > high - low ? covered - (high - low) : 0;
  const std::size_t first = low > beyond / 2 ? low - beyond / 2 : 0;
  return {std::min(first, taxels - covered), blocks};
}

void SquareBlocks::sum(const ContactPatch& patch, double along_radius) noexcept {
  const double pitch = grid_.pitch_m, sides = patch.radius_m / pitch;
  const auto narrowest = static_cast<double>(std::min(grid_.columns, grid_.rows));
  along_ = static_cast<std::size_t>(std::clamp(std::floor(sides / along_radius), 1.0, narrowest));
  side_m_ = pitch * static_cast<double>(along_);
  const double reach_m = kPatch.reach_factor * patch.radius_m + kHalfDiagonal * side_m_;
  const Span across = cover((patch.center_x_m - grid_left_m_) / pitch, reach_m / pitch, grid_.columns),
             up = cover((patch.center_y_m - grid_bottom_m_) / pitch, reach_m / pitch, grid_.rows);
  left_m_ = grid_left_m_ + pitch * static_cast<double>(across.first) - patch.center_x_m;
  bottom_m_ = grid_bottom_m_ + pitch * static_cast<double>(up.first) - patch.center_y_m;
  rows_.clear();
  size_ = 0;
  const auto most = static_cast<double>(across.blocks);
  for (std::size_t row = 0; row < up.blocks; ++row) {
    const double y = bottom_m_ + side_m_ * (static_cast<double>(row) + 0.5);
    const double half = std::sqrt(std::max(0.0, reach_m * reach_m - y * y));
    const auto column_of = [&](double x) { return std::clamp((x - left_m_) / side_m_ - 0.5, -1.0, most); };
    const auto first = static_cast<std::size_t>(std::ceil(std::max(0.0, column_of(-half)))),
               end = static_cast<std::size_t>(std::floor(column_of(half)) + 1);
    const std::size_t count = std::min(end, across.blocks) > first ? std::min(end, across.blocks) - first : 0;
    rows_.push_back({static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(first + count)});
    for (std::size_t i = 0; i < count; ++i) {
      x_m_[size_ + i] = left_m_ + side_m_ * (static_cast<double>(first + i) + 0.5);
      y_m_[size_ + i] = y;
    }
    sum_row(patch, (up.first + row * along_) * grid_.columns + across.first + first * along_, count);
    size_ += count;
  }
}

// Column by column of taxels first, along which a loop runs on vectors.
void SquareBlocks::sum_row(const ContactPatch& patch, std::size_t first_taxel, std::size_t blocks) noexcept {
  const std::size_t columns = blocks * along_;
  const auto c = static_cast<float>(patch.direction_x), s = static_cast<float>(patch.direction_y);
  float* const p = row_normal_.data();
  float* const q = row_shear_.data();
  std::fill_n(p, columns, 0.0F);
  std::fill_n(q, columns, 0.0F);
  for (std::size_t row = 0; row < along_; ++row) {
    const std::size_t first = first_taxel + row * grid_.columns;
    const float* const normal = patch.taxels.normal_pa + first;
    const float* const shear_x = patch.taxels.shear_x_pa + first;
    const float* const shear_y = patch.taxels.shear_y_pa + first;
#pragma omp simd
    for (std::size_t i = 0; i < columns; ++i) {
      p[i] += normal[i];
      q[i] += c * shear_x[i] + s * shear_y[i];
    }
  }
  const double per_taxel = 1 / static_cast<double>(along_ * along_);
  for (std::size_t block = 0; block < blocks; ++block) {
    float normal = 0, shear = 0;
    for (std::size_t i = block * along_; i < (block + 1) * along_; ++i) {
      normal += p[i];
      shear += q[i];
    }
    normal_pa_[size_ + block] = per_taxel * static_cast<double>(normal);
    shear_pa_[size_ + block] = per_taxel * static_cast<double>(shear);
  }
}

}  // namespace slipd
