#include "core/contact/subsurface/dome_lattice.hpp"

#include <algorithm>

#include "core/contact/subsurface/dome.hpp"
#include "core/simd/inlined_loops.hpp"
#include "core/simd/instruction_sets.hpp"

namespace slipd::contact {
namespace {

struct CornerLists {
  const double *u, *v;
  double *value, *d_x, *d_u, *d_v;
  std::size_t count;
  double x, center_x, center_y;
};

[[gnu::always_inline]] inline void fill_corners(const CornerLists& at) noexcept {
#pragma omp simd
  for (std::size_t i = 0; i < at.count; ++i) {
    const auto corner = dome_corner(at.x, at.u[i] - at.center_x, at.v[i] - at.center_y);
    at.value[i] = corner.value;
    at.d_x[i] = corner.d_x;
    at.d_u[i] = corner.d_u;
    at.d_v[i] = corner.d_v;
  }
}

// Corners are computed in whole vectors of the widest registers: a rest of single ones takes longer.
constexpr std::size_t in_vectors(std::size_t corners) noexcept {
  constexpr std::size_t kLanes = 8;
  return (corners + kLanes - 1) / kLanes * kLanes;
}

struct LatticeKernels {
  void (*corners)(const CornerLists&) noexcept;
  static const LatticeKernels baseline, avx2, avx512;  // chosen by best_kernels
};
const LatticeKernels LatticeKernels::baseline{on_baseline<fill_corners>};
#if defined(__x86_64__)
const LatticeKernels LatticeKernels::avx2{on_avx2<fill_corners>};
const LatticeKernels LatticeKernels::avx512{on_avx512<fill_corners>};
#endif

}  // namespace

DomeLattice::DomeLattice(std::size_t most_along) : below_(most_along + 1), above_(most_along + 1) {
  rows_.reserve(most_along + 1);
  for (auto* list : {&u_, &v_, &value_, &d_x_, &d_u_, &d_v_})
    list->resize(in_vectors((most_along + 1) * (most_along + 1)));
  best_kernels<LatticeKernels>();  // not first within a fit
}

// A height between two rows has the corners of both.
void DomeLattice::set(const SquareLattice& lattice) noexcept {
  side_m_ = lattice.side_m;
  squares_ = lattice.rows;
  rows_.clear();
  corners_ = 0;
  for (std::size_t height = 0; height <= squares_.size(); ++height) {
    const TaxelRun below = height > 0 ? squares_[height - 1] : TaxelRun{},
                   above = height < squares_.size() ? squares_[height] : TaxelRun{};
    const bool no_below = below.first == below.end, no_above = above.first == above.end;
    CornerRow row{.start = static_cast<std::uint32_t>(corners_)};
    if (!no_below || !no_above) {
      const TaxelRun one = no_below ? above : below, other = no_above ? below : above;
      row.first = std::min(one.first, other.first);
      row.count = std::max(one.end, other.end) - row.first + 1;
    }
    for (std::uint32_t i = 0; i < row.count; ++i, ++corners_) {
      u_[corners_] = lattice.left_m + side_m_ * (row.first + i);
      v_[corners_] = lattice.bottom_m + side_m_ * static_cast<double>(height);
    }
    rows_.push_back(row);
  }
}

void DomeLattice::evaluate(double x, double center_x_m, double center_y_m, const DomeAverages& out) noexcept {
  best_kernels<LatticeKernels>().corners({u_.data(), v_.data(), value_.data(), d_x_.data(), d_u_.data(),
                                          d_v_.data(), in_vectors(corners_), x, center_x_m, center_y_m});
  put(value_, out.value);
  put(d_x_, out.d_x);
  put(d_u_, out.d_u);
  put(d_v_, out.d_v);
}

RingSums DomeLattice::ring_sums(const PerRing& radii, double center_x_m, double center_y_m,
                                std::span<const double> whole, std::span<const double> field) noexcept {
  RingSums sums;
  std::size_t at = 0;
  for (std::size_t height = 0; height < rows_.size(); ++height) {
    const CornerRow& corners = rows_[height];
    integrate_domes(radii, {u_.data() + corners.start, corners.count},
                    {v_.data() + corners.start, corners.count}, center_x_m, center_y_m, above_);
    if (height > 0) {
      const TaxelRun& run = squares_[height - 1];
      const std::size_t count = run.end - run.first;
      add_rings({.below = below_.data() + (run.first - rows_[height - 1].first),
                 .above = above_.data() + (run.first - corners.first),
                 .whole = whole.subspan(at, count),
                 .field = field.subspan(at, count),
                 .per_area = 1 / (side_m_ * side_m_)},
                sums);
      at += count;
    }
    std::swap(below_, above_);
  }
  return sums;
}

// Inclusion and exclusion of each square's four corners.
void DomeLattice::put(const std::vector<double>& of, std::span<double> to) const noexcept {
  const double per_area = 1 / (side_m_ * side_m_);
  double* out = to.data();
  for (std::size_t r = 0; r < squares_.size(); ++r) {
    const TaxelRun& run = squares_[r];
    if (run.first == run.end) continue;
    const double* const below = of.data() + rows_[r].start + run.first - rows_[r].first;
    const double* const above = of.data() + rows_[r + 1].start + run.first - rows_[r + 1].first;
    const std::size_t count = run.end - run.first;
#pragma omp simd
    for (std::size_t i = 0; i < count; ++i)
      out[i] = ((above[i + 1] - above[i]) - (below[i + 1] - below[i])) * per_area;
    out += count;
  }
}

}  // namespace slipd::contact
