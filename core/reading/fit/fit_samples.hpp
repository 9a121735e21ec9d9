// What a fit compares with the contact model: taxels, or taxels summed in square blocks. Both average a dome
// over each of their samples. Estimate thread; allocates in constructors only.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/contact/subsurface/dome_averages.hpp"
#include "core/contact/subsurface/dome_lattice.hpp"
#include "core/contact/subsurface/dome_rings.hpp"
#include "core/frame/layout.hpp"
#include "core/patch/patch.hpp"
#include "core/patch/square_blocks.hpp"
#include "core/simd/taxel_runs.hpp"

namespace slipd {

class FitSamples {
 public:
  virtual ~FitSamples() = default;

  std::size_t most() const noexcept { return x_m_.size(); }
  std::size_t count() const noexcept { return count_; }
  // Of each: its middle relative to the patch's centre, m; pressure, and shear along the pull, Pa.
  std::span<const double> x_m() const noexcept { return {x_m_.data(), count_}; }
  std::span<const double> y_m() const noexcept { return {y_m_.data(), count_}; }
  std::span<const double> normal_pa() const noexcept { return {normal_pa_.data(), count_}; }
  std::span<const double> shear_pa() const noexcept { return {shear_pa_.data(), count_}; }
  // A sample's noise is that of the mean of the square of so many taxels.
  virtual double taxels_along() const noexcept { return 1; }

  // A dome of radius x about (center_x, center_y) relative to the patch's centre, averaged over each sample;
  // all in m. The lists have room for most().
  virtual void average(double x, double center_x_m, double center_y_m,
                       const contact::DomeAverages& out) noexcept = 0;
  // Domes of these radii about the same centre, and what each leaves of `whole`, a wider one, averaged over
  // each sample: its squares, and its products with the shear along the pull.
  virtual contact::RingSums ring_sums(const contact::PerRing& radii, double center_x_m, double center_y_m,
                                      std::span<const double> whole) noexcept = 0;

  virtual std::size_t memory_bytes() const noexcept = 0;

 protected:
  explicit FitSamples(std::size_t most) : x_m_(most), y_m_(most), normal_pa_(most), shear_pa_(most) {}
  std::size_t list_bytes() const noexcept { return 4 * sizeof(double) * most(); }

  std::vector<double> x_m_, y_m_, normal_pa_, shear_pa_;
  std::size_t count_ = 0;
};

// Taxels by themselves.
class TaxelSamples final : public FitSamples {
 public:
  explicit TaxelSamples(const TaxelLayout& layout);

  void collect_inside(const ContactPatch& patch) noexcept { collect(patch, patch.runs); }
  // Those without load as well.
  void collect_all(const ContactPatch& patch) noexcept { collect(patch, all_); }

  void average(double x, double center_x_m, double center_y_m,
               const contact::DomeAverages& out) noexcept override;
  contact::RingSums ring_sums(const contact::PerRing& radii, double center_x_m, double center_y_m,
                              std::span<const double> whole) noexcept override;
  std::size_t memory_bytes() const noexcept override;

 private:
  // runs: in order of taxels; of a grid one of each row at most, and no row left out.
  void collect(const ContactPatch& patch, std::span<const TaxelRun> runs) noexcept;
  // Places relative to a dome's centre into u_ and v_.
  void place(double center_x_m, double center_y_m) noexcept;

  const TaxelLayout layout_;
  std::vector<TaxelRun> all_;
  // Of a grid: the columns of each row. Of other layouts: places.
  std::optional<contact::DomeLattice> lattice_;
  std::vector<TaxelRun> rows_;
  std::vector<double> u_, v_;
};

// Square blocks of the taxels of a grid.
class BlockSamples final : public FitSamples {
 public:
  // most_along_radius: of those that are asked for.
  BlockSamples(const TaxelLayout& layout, double most_along_radius)
      : BlockSamples(SquareBlocks(layout, most_along_radius)) {}

  // So many along the contact's radius, or up to twice as many.
  void collect(const ContactPatch& patch, double along_radius) noexcept;

  double taxels_along() const noexcept override { return static_cast<double>(blocks_.taxels_along()); }
  void average(double x, double center_x_m, double center_y_m,
               const contact::DomeAverages& out) noexcept override {
    lattice_.evaluate(x, center_x_m, center_y_m, out);
  }
  contact::RingSums ring_sums(const contact::PerRing& radii, double center_x_m, double center_y_m,
                              std::span<const double> whole) noexcept override {
    return lattice_.ring_sums(radii, center_x_m, center_y_m, whole, shear_pa());
  }
  std::size_t memory_bytes() const noexcept override {
    return list_bytes() + blocks_.memory_bytes() + lattice_.memory_bytes();
  }

 private:
  explicit BlockSamples(SquareBlocks blocks);

  SquareBlocks blocks_;
  contact::DomeLattice lattice_;
};

}  // namespace slipd
