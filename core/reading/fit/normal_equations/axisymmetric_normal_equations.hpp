// Residuals and normal equations of a round contact under a skin (docs/methods.md §23.7). What taxels read of
// it is made of five functions of the distance from its centre, which are tabulated for each trial contact.
// That takes a fraction of the time of SubsurfaceSheet. Estimate thread; nothing allocates after
// construction.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "core/contact/subsurface/subsurface.hpp"
#include "core/reading/fit/normal_equations/radial_field_table.hpp"
#include "core/reading/fit/normal_equations/slope_block.hpp"

namespace slipd {

// The taxels of a frame, and where results are written.
struct RoundTask {
  // Centres of `count` taxels, m.
  const double *x_m = nullptr, *y_m = nullptr;
  // Pressures of all, then both shears, Pa.
  const double* data_pa = nullptr;
  // Of the same order, in units of noise.
  double* residuals = nullptr;
  std::size_t count = 0;
  // One over the noise of a taxel, 1/Pa.
  double per_normal = 0, per_shear = 0;
};

class AxisymmetricNormalEquations {
 public:
  // The last one is the log of the depth.
  static constexpr std::size_t kUnknowns = 8;

  // side_m: of the taxels; depth_m > 0. bonded_poisson: see Skin.
  AxisymmetricNormalEquations(double side_m, double depth_m,
                              std::optional<double> bonded_poisson = std::nullopt);

  // Another depth, > 0, within a factor of 2 of the first one, by which averages are chosen.
  void set_depth(double depth_m) noexcept {
    depth_m_ = depth_m;
    table_.set_depth(depth_m);
  }

  // Whether so many taxels, no farther than reach_m from the centre, take less time than with a
  // SubsurfaceSheet of so many points along a side.
  bool pays(std::size_t count, double reach_m, contact::SubsurfaceSheet::Detail detail,
            std::size_t sheet_points) const noexcept;

  // Averages over taxels are within 1e-4 of the peak pressure with `exact`, and within about 1e-3 with
  // `rough`. pays() holds.
  void linearise(const RoundTrial& trial, double reach_m, contact::SubsurfaceSheet::Detail detail,
                 const RoundTask& task, ChannelProducts& products) noexcept;

  std::size_t memory_bytes() const noexcept { return table_.memory_bytes(); }

 private:
  // Parts of a taxel's side.
  std::size_t parts_along(contact::SubsurfaceSheet::Detail detail) const noexcept {
    return parts_[detail == contact::SubsurfaceSheet::Detail::exact ? 0 : 1];
  }

  const double side_m_;
  double depth_m_;                    // of the taxels under the surface, as far as it is known
  std::array<std::size_t, 2> parts_;  // exact, rough
  RadialFieldTable table_;
};

}  // namespace slipd
