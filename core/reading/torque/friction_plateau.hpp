// Friction from the taxels that slip, where force and torque act together (docs/methods.md §27.2). The shear
// is then no sum of disc terms, and which part of the rim slips first depends on both; but where it slips,
// |q|/p is friction. So the ratios |q|/p of the taxels end in a plateau, whatever the shape of the contact
// and the history of its load. No disc, no Hertz. Estimate thread; allocates in its constructor only.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "core/frame/layout.hpp"
#include "core/frame/significance.hpp"
#include "core/numeric/running_mean.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/method/method.hpp"
#include "core/reading/torque/torque_kernels.hpp"

namespace slipd {

// Ratio: |q|/p of a taxel. Checked on frames of a solver that shares no equation with slipd, from pure force
// to pure torque, on 8 x 8 to 32 x 32 taxels with 1 to 5 % of sensor noise.
struct FrictionPlateauOptions {
  // A taxel counts if its pressure stands out of the noise and is above this share of the peak; 0 … 0.2. Too
  // small: ratios are noise. Too large: the rim, which slips first, is left out.
  double least_share = 0.05;
  // Of grids' contacts with more taxels than this every n-th row counts; 500 … 10000. Too small: more noise.
  // Too large: costs time.
  std::size_t most_taxels = 1500;
  // Share of the load that is below the ratio from which the plateau is looked for; 0.9 … 0.995. Too small: a
  // stuck part is taken for the plateau. Too large: noise is.
  double start_share = 0.97;
  // Floor of a ratio's standard deviation, relative: gains of taxels; 0.002 … 0.05. Too small: gains scatter
  // taxels out of the plateau. Too large: taxels that stick draw it down.
  double gain_share = 0.01;
  // The least share of the load that slips, over that of a pull with the margin found; 0.2 … 0.8. Too small:
  // a peak of ratios passes for a plateau. Too large: frames of a torque are refused.
  double least_slipping = 0.35;
  // Standard deviation of friction over that by noise, and, over the mean width of a ratio's noise times
  // (rounded_base + Gamma + rounded_steep Gamma^4), that by taxels which nearly slip; 1 … 3, 0 … 1, 0 … 4.
  // Too small: sigma is less than the error. Too large: it is more.
  double noise_factor = 1.3;
  double rounded_base = 0.15;
  double rounded_steep = 1.6;
  // Above this margin nothing is answered: the part that slips is narrower than a few taxels; Gamma, 0.5 …
  // 0.9. Too small: frames that show friction are refused. Too large: a peak of ratios passes for a plateau.
  double max_gamma = 0.72;
};

class FrictionPlateau {
 public:
  explicit FrictionPlateau(const TaxelLayout& layout, const FrictionPlateauOptions& options = {});

  // `loaded` is in contact; its shear_n is the pull that asks for as much of friction as force and torque
  // together. in_model is false where no plateau is seen. `turning` is set.
  Reading estimate(const ContactPatch& loaded) noexcept;
  // Whether all of the contact slipped in the last frame.
  bool all_slipped() const noexcept { return frame_.all_slipped; }
  // Whether ratios fell towards the rim in the last frames: they are of taxels that stick.
  bool rising() const noexcept { return slope_.mean > kClearSigmas * sigma_of_mean(kSlowGain); }
  // A new grasp.
  void forget() noexcept { slope_ = {}; }

 private:
  struct Plateau {
    double ratio = 0, weight = 0, width = 0;  // 1/variance of the ratio; weighted mean of the taxels' sigmas
    double normal_pa = 0;                     // sum over its taxels
    // How the ratio rises with pressure within the plateau, 1/Pa, and its standard deviation.
    double slope = 0, slope_sigma = 0;
    std::size_t taxels = 0;
  };
  void collect(const ContactPatch& patch) noexcept;
  double start() const noexcept;
  PlateauTest test_about(double ratio) const noexcept;
  void follow_slope(double sigmas) noexcept;
  Plateau find_plateau() const noexcept;  // without taxels if there is none

  // Ratios that the start is looked for in: up to kMostRatio, beyond what friction may be; in steps.
  static constexpr double kMostRatio = 4, kStartStep = kMostRatio / 512;

  const FrictionPlateauOptions options_;
  const TorqueKernels& kernels_;
  const bool rows_;  // each run of taxels is of one row
  struct ThisFrame {
    double noise_normal_pa = 0, noise_shear_pa = 0, normal_pa = 0;
    std::size_t stored = 0, count = 0;  // values in the lists, taxels that count
    bool all_slipped = false;
  };
  ThisFrame frame_;
  struct MeanSlope {
    double mean = 0, frames = 0;  // in standard deviations; that were averaged
  };
  MeanSlope slope_;
  std::vector<float> pressure_pa_, ratio_;
};

}  // namespace slipd
