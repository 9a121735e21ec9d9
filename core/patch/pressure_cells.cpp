#include "core/patch/pressure_cells.hpp"

#include <algorithm>
#include <cmath>

#include "core/simd/instruction_sets.hpp"

namespace slipd {

PressureCells::PressureCells(const TaxelLayout& layout)
    : layout_(layout), kernels_(best_kernels<DiscKernels>()) {
  if (const auto& grid = layout.regular()) {
    sums_.resize(grid->columns);
    moments_.resize(grid->columns);
  }
}

// The torque that is sensed lacks what turns within each taxel: of a taxel with lever r, h^2/(24 r) of
// friction, as much as its spread adds to what it can hold. So the cell's spread counts without twice the
// taxel's. A single taxel keeps a little, which rounds the kink over the instantaneous centre.
double PressureCells::spread_side(double across) const noexcept {
  constexpr double kLeast = 0.1;
  return layout_.side_m() * std::sqrt(std::max(kLeast, across * across - 2));
}

const contact::LimitSurface& PressureCells::pool(const ContactPatch& patch) noexcept {
  if (layout_.regular()) {
    pool_grid(patch);
  } else {
    pool_scattered(patch);
  }
  return surface_;
}

// Runs of a grid are stretches of one row each, in order of rows.
PressureCells::Box PressureCells::box_of(const ContactPatch& patch) const noexcept {
  const std::size_t columns = layout_.regular()->columns;
  Box box{.first_row = patch.runs.front().first / columns,
          .end_row = patch.runs.back().first / columns + 1,
          .first_column = columns,
          .end_column = 0};
  for (const TaxelRun& run : patch.runs) {
    const std::size_t row = run.first / columns * columns;
    box.first_column = std::min(box.first_column, run.first - row);
    box.end_column = std::max(box.end_column, run.end - row);
  }
  return box;
}

void PressureCells::pool_grid(const ContactPatch& patch) noexcept {
  surface_.clear(spread_side(1));
  if (patch.runs.empty()) return;
  const Box box = box_of(patch);
  const std::size_t columns = layout_.regular()->columns, width = box.end_column - box.first_column;
  const std::size_t longest = std::max(box.end_row - box.first_row, width);
  const std::size_t across = (longest + kAcross - 1) / kAcross;  // taxels of a cell along each side
  surface_.clear(spread_side(static_cast<double>(across)));
  taxels_ = across == 1;
  auto run = patch.runs.begin();
  for (std::size_t first = box.first_row; first < box.end_row; first += across) {
    const std::size_t rows = std::min(across, box.end_row - first);
    std::fill_n(sums_.begin(), width, 0.0F);
    std::fill_n(moments_.begin(), width, 0.0F);
    for (; run != patch.runs.end() && run->first / columns < first + rows; ++run) {
      const std::size_t row = run->first / columns, column = run->first - row * columns - box.first_column;
      kernels_.add_row(patch.taxels.normal_pa + run->first, run->end - run->first,
                       static_cast<float>(row - first), sums_.data() + column, moments_.data() + column);
    }
    end_band(patch, box, first, rows, across);
  }
}

// The columns of a band, `across` by `across`. A cell of noise alone has no centre of its own: it is kept
// within the cell.
void PressureCells::end_band(const ContactPatch& patch, const Box& box, std::size_t first_row,
                             std::size_t rows, std::size_t across) noexcept {
  const double pitch_m = layout_.regular()->pitch_m, area_m2 = layout_.area_m2();
  const std::size_t columns = layout_.regular()->columns, width = box.end_column - box.first_column;
  const std::size_t corner = first_row * columns + box.first_column;
  const double left_m = layout_.x_m()[corner] - patch.center_x_m;
  const double bottom_m = layout_.y_m()[corner] - patch.center_y_m;
  for (std::size_t from = 0; from < width; from += across) {
    const std::size_t end = std::min(from + across, width);
    float all = 0, moment = 0, rows_moment = 0, step = 0;  // of at most some tens of taxels: single will do
    for (std::size_t i = from; i < end; ++i, step += 1) {
      all += sums_[i];
      moment += sums_[i] * step;
      rows_moment += moments_[i];
    }
    const auto normal = static_cast<double>(all);
    const double by_column = static_cast<double>(moment) + normal * static_cast<double>(from);
    const auto by_row = static_cast<double>(rows_moment);
    if (normal == 0) continue;
    const double column =
        std::clamp(by_column / normal, static_cast<double>(from), static_cast<double>(end - 1));
    const double row = std::clamp(by_row / normal, 0.0, static_cast<double>(rows - 1));
    surface_.add(left_m + pitch_m * column, bottom_m + pitch_m * row, normal * area_m2);
  }
}

void PressureCells::pool_scattered(const ContactPatch& patch) noexcept {
  surface_.clear(spread_side(1));
  const auto x_m = layout_.x_m(), y_m = layout_.y_m();
  const float* const p = patch.taxels.normal_pa;
  const double area_m2 = layout_.area_m2();
  taxels_ = patch.count <= cells_.size();
  if (taxels_) {
    patch.for_each_inside([&](std::uint32_t i) {
      surface_.add(x_m[i] - patch.center_x_m, y_m[i] - patch.center_y_m, static_cast<double>(p[i]) * area_m2);
    });
    return;
  }
  double reach_m = 0;
  patch.for_each_inside([&](std::uint32_t i) {
    reach_m = std::max({reach_m, std::fabs(x_m[i] - patch.center_x_m), std::fabs(y_m[i] - patch.center_y_m)});
  });
  const double cell_m = 2 * reach_m / kAcross;
  cells_.fill({});
  const auto index = [&](double place_m) {
    const auto at = static_cast<std::size_t>(std::max(0.0, (place_m + reach_m) / cell_m));
    return std::min(at, kAcross - 1);
  };
  patch.for_each_inside([&](std::uint32_t i) {
    const double x = x_m[i] - patch.center_x_m, y = y_m[i] - patch.center_y_m;
    const auto normal = static_cast<double>(p[i]);
    Cell& cell = cells_[index(y) * kAcross + index(x)];
    cell.normal += normal;
    cell.x += normal * x;
    cell.y += normal * y;
  });
  surface_.clear(spread_side(cell_m / layout_.side_m()));
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const Cell& cell = cells_[i];
    if (cell.normal == 0) continue;
    const std::size_t column = i % kAcross, row = i / kAcross;
    const double left_m = static_cast<double>(column) * cell_m - reach_m;
    const double bottom_m = static_cast<double>(row) * cell_m - reach_m;
    surface_.add(std::clamp(cell.x / cell.normal, left_m, left_m + cell_m),
                 std::clamp(cell.y / cell.normal, bottom_m, bottom_m + cell_m), cell.normal * area_m2);
  }
}

}  // namespace slipd
