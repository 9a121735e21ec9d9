// The margin under force and torque from how far out the shear lies (docs/methods.md §27.4), where taxels are
// too coarse to resolve the part that slips: as the moment ratio does for a pull (theory.md §7.1). For loads
// that rose in a straight line, on round contacts. Estimate thread; allocates nothing.
#pragma once

#include "core/frame/layout.hpp"
#include "core/load/equivalent_pull.hpp"
#include "core/patch/hertz_deviation.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

// Margin under torque from which on taxels that nearly slip round off the plateau of those that slip; Gamma,
// 0.3 … 0.7: there moments answer, where both agree. Too small: moments are computed for nothing, and skins
// that are no half space get margins that are too low. Too large: margins are too low where a plateau is
// rounded, and coarse arrays get no answer.
inline constexpr double kRoundedGamma = 0.55;

// Dimensionless unless a unit is given. side: a taxel's side; a: the contact's radius. Checked with
// `slipd-lab torque --sides 16,32`.
struct TorqueMomentRatioOptions {
  HertzDeviationOptions deviation;
  // Floor of the ratio's sigma: of the relation to Gamma, and of paths that are not quite straight; 0 … 0.1.
  // Too small and too large: as above.
  double ratio_floor = 0.015;
  // The ratio of fourth moments agrees with that of a half space within the sum of its noise, kCoarseTorque,
  // and this; 0.02 … 0.2. Too small: half spaces are refused. Too large: Winkler foundations and other
  // histories pass.
  double fourth_slack = 0.05;
  // Contacts with a smaller side/a are answered above kRoundedGamma only; 0 … 0.4. Below it FrictionPlateau,
  // which assumes no half space, finds what slips. A skin like a Winkler foundation has ratios as a half
  // space near slip, so that a ratio of a large margin is none of it. Too small: such skins get margins that
  // are too low. Too large: fine arrays get no answer.
  double least_coarse = 0.15;
  // The greatest noise of the ratio: with more, neither the history nor the half space is checked;
  // 0.005 … 0.1. Too small: light loads get no answer. Too large: other histories and skins pass.
  double max_noise = 0.035;
};

class TorqueMomentRatio {
 public:
  explicit TorqueMomentRatio(const TaxelLayout& layout, const TorqueMomentRatioOptions& options = {});

  // `loaded`: as FrictionPlateau takes it; `load`: of that frame, bending. in_model is false for contacts
  // that are cut or not round, and for other histories as far as the ratio shows them. `turning` is set.
  Reading estimate(const ContactPatch& loaded, const EquivalentPullResult& load) const noexcept;

 private:
  // Of (10.5), its standard deviation by noise, and the same ratio of fourth moments.
  struct Ratio {
    double value = 0, noise = 0, fourth = 0;
  };
  // spin_share: the object's spin times a over the sum of that and its speed, 0 (a pull) … 1 (a torque
  // alone).
  static Ratio as_of_pull(const Ratio& ratio, double spin_share) noexcept;
  bool half_space(const Ratio& ratio, double gamma, double coarse) const noexcept;
  Ratio ratio_of(const ContactPatch& patch, double along, double spin) const noexcept;

  const TorqueMomentRatioOptions options_;
  const double side_m_, area_m2_;
};

}  // namespace slipd
