// Whether what a fit of a round contact under a skin leaves over shows that its contact is an ellipse
// (docs/methods.md §23.6): a score test (Rao 1948). An ellipse that is hardly one changes what taxels read by
// functions of the distance from the centre, times sine or cosine of twice the angle. They are tabulated, in
// a fraction of the time of SubsurfaceSheet. Estimate thread; nothing allocates after construction.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/contact/subsurface/subsurface.hpp"
#include "core/reading/fit/normal_equations/axisymmetric_normal_equations.hpp"

namespace slipd {

class EllipticityTest {
 public:
  // depth_m > 0. bonded_poisson: see Skin.
  EllipticityTest(double depth_m, std::optional<double> bonded_poisson);

  void set_depth(double depth_m) noexcept { sheet_.set_depth(depth_m); }

  // Whether all taxels are near enough for the table.
  bool reaches(double reach_m) const noexcept { return nodes_for(reach_m) <= kMostNodes; }

  // Squared length of a step of Newton's method from the trial to an ellipse, in standard deviations: of two
  // degrees of freedom. The residuals of `task` are those of the trial with the greatest likelihood. No taxel
  // is farther from its centre than reach_m, for which reaches().
  double sigmas2(const RoundTrial& trial, double reach_m, const RoundTask& task) noexcept;

  std::size_t memory_bytes() const noexcept {
    return sheet_.memory_bytes() + sizeof(double) * (u_.size() + v_.size() + table_.size());
  }

  static constexpr std::size_t kFunctions = 8, kMostNodes = 160;

 private:
  std::size_t nodes_for(double reach_m) const noexcept;
  void add_dome(double radius_m, double of_pressure, double of_shear, std::size_t nodes) noexcept;

  contact::SubsurfaceSheet sheet_;
  std::vector<double> u_, v_, table_;
};

}  // namespace slipd
