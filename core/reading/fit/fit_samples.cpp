#include "core/reading/fit/fit_samples.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

namespace slipd {

TaxelSamples::TaxelSamples(const TaxelLayout& layout) : FitSamples(layout.size()), layout_(layout) {
  const auto& grid = layout.regular();
  const std::size_t rows = grid ? grid->rows : 1, columns = layout.size() / rows;
  for (std::size_t row = 0; row < rows; ++row) {
    all_.push_back(
        {static_cast<std::uint32_t>(row * columns), static_cast<std::uint32_t>((row + 1) * columns)});
  }
  if (grid) {
    lattice_.emplace(std::max(rows, columns));
    rows_.reserve(rows);
  } else {
    u_.resize(layout.size());
    v_.resize(layout.size());
  }
}

std::size_t TaxelSamples::memory_bytes() const noexcept {
  return list_bytes() + (lattice_ ? lattice_->memory_bytes() : 0) + sizeof(double) * 2 * u_.size() +
         sizeof(TaxelRun) * (all_.size() + rows_.capacity());
}

void TaxelSamples::collect(const ContactPatch& patch, std::span<const TaxelRun> runs) noexcept {
  count_ = 0;
  for (const TaxelRun& run : runs) {
    for (std::uint32_t i = run.first; i < run.end; ++i, ++count_) {
      x_m_[count_] = layout_.x_m()[i] - patch.center_x_m;
      y_m_[count_] = layout_.y_m()[i] - patch.center_y_m;
      normal_pa_[count_] = patch.taxels.normal_pa[i];
      shear_pa_[count_] = patch.shear_along_pa(i);
    }
  }
  if (!lattice_ || count_ == 0) return;
  const auto columns = static_cast<std::uint32_t>(layout_.regular()->columns);
  rows_.clear();
  for (const TaxelRun& run : runs) {
    const std::uint32_t first = run.first % columns;
    rows_.push_back({first, first + run.end - run.first});
  }
  // The first sample is in the first run's first column.
  const double side = layout_.side_m();
  lattice_->set({.left_m = x_m_.front() - side * (rows_.front().first + 0.5),
                 .bottom_m = y_m_.front() - 0.5 * side,
                 .side_m = side,
                 .rows = rows_});
}

void TaxelSamples::place(double center_x_m, double center_y_m) noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    u_[i] = x_m_[i] - center_x_m;
    v_[i] = y_m_[i] - center_y_m;
  }
}

void TaxelSamples::average(double x, double center_x_m, double center_y_m,
                           const contact::DomeAverages& out) noexcept {
  if (lattice_) return lattice_->evaluate(x, center_x_m, center_y_m, out);
  place(center_x_m, center_y_m);
  contact::average_dome(x, layout_.side_m(), {u_.data(), count_}, {v_.data(), count_}, out);
}

contact::RingSums TaxelSamples::ring_sums(const contact::PerRing& radii, double center_x_m, double center_y_m,
                                          std::span<const double> whole) noexcept {
  if (lattice_) return lattice_->ring_sums(radii, center_x_m, center_y_m, whole, shear_pa());
  contact::RingSums sums;
  const double side = layout_.side_m(), half = 0.5 * side;
  for (std::size_t i = 0; i < count_; ++i) {
    const std::array u{x_m_[i] - half, x_m_[i] + half, x_m_[i] - half, x_m_[i] + half},
        v{y_m_[i] - half, y_m_[i] - half, y_m_[i] + half, y_m_[i] + half};
    std::array<contact::PerRing, 4> corners;
    contact::integrate_domes(radii, u, v, center_x_m, center_y_m, corners);
    contact::add_rings({.below = corners.data(),
                        .above = corners.data() + 2,
                        .whole = whole.subspan(i, 1),
                        .field = shear_pa().subspan(i, 1),
                        .per_area = 1 / (side * side)},
                       sums);
  }
  return sums;
}

BlockSamples::BlockSamples(SquareBlocks blocks)
    : FitSamples(blocks.most_along() * blocks.most_along()),
      blocks_(std::move(blocks)),
      lattice_(blocks_.most_along()) {}

void BlockSamples::collect(const ContactPatch& patch, double along_radius) noexcept {
  blocks_.sum(patch, along_radius);
  lattice_.set({.left_m = blocks_.left_m(),
                .bottom_m = blocks_.bottom_m(),
                .side_m = blocks_.side_m(),
                .rows = blocks_.rows()});
  count_ = blocks_.size();
  std::copy_n(blocks_.x_m().begin(), count_, x_m_.begin());
  std::copy_n(blocks_.y_m().begin(), count_, y_m_.begin());
  std::copy_n(blocks_.normal_pa().begin(), count_, normal_pa_.begin());
  std::copy_n(blocks_.shear_pa().begin(), count_, shear_pa_.begin());
}

}  // namespace slipd
