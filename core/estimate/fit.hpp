// Maximum likelihood: the contact model itself, averaged over every taxel, fitted to pressure and shear
// together (docs/theory.md §10). The method that costs most time, and the one that
// comes near what the noise allows (the Cramer-Rao limit), on any layout, with part of the contact beyond the
// sensor's edge, or with taxels dead.
//
// Unknown are the centre, the radius a, the pressure's height B = p0/a, the load T = Q/P and Gamma:
//   p = B A(a),   q = B T (A(a) - A(k a)) / (1 - Gamma),   k^3 = Gamma,   A(x) the average of sqrt(x^2 -
//   r^2).
// T and Gamma stay well apart at any load, where mu and k would not: near no load only mu (1 - k) is felt.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/contact/dome_sheet.hpp"
#include "core/contact/scene.hpp"
#include "core/estimate/friction_prior.hpp"
#include "core/estimate/method.hpp"
#include "core/estimate/moments.hpp"

namespace slipd {

// Dimensionless unless a unit is given. Checked with `sliplab tradeoff --no-models`, rows of fit: sigma is
// right where 68 % of the answers are within it; those of a real skin with `sliplab stability --parts
// adversary`. peak: a Hertz contact's largest pressure p0.
struct FitOptions {
  MomentRatioOptions ratio;
  FrictionPriorOptions prior;

  // Range of Gamma within which the fit searches; 1e-9 … 0.01 and 0.99 … 1. Too wide: the normal equations
  // are singular at the ends. Too narrow: answers near the ends are drawn inwards.
  double min_gamma = 1e-6;
  double max_gamma = 1 - 1e-4;
  // Range of Gamma from which it starts; within the one above. Too wide: it starts where slopes vanish, and
  // does not converge. Too narrow: more steps.
  double min_start = 0.05;
  double max_start = 0.95;
  // The most by which one step may change the radius; factor, 1.1 … 10. Too small: more steps. Too large: a
  // wild step leaves the taxels.
  double max_radius_factor = 2;
  // Levenberg-Marquardt's first damping, the factor by which it falls or grows, its least, and the one from
  // which on no step makes the fit better; 1e-6 … 1, 2 … 100, 0 … 1e-6, 1e3 … 1e12. Too small a first one:
  // steps are refused. Too large: more steps.
  double first_damping = 1e-3;
  double damping_factor = 10;
  double min_damping = 1e-9;
  double max_damping = 1e6;
  // It has converged when no unknown moves by more than this, in its own standard deviation; 1e-6 … 0.1. Too
  // small: more steps, for nothing. Too large: it stops before the minimum.
  double converged_sigmas = 1e-3;
  // Floor of a taxel's noise, of the peak; 1e-8 … 0.01. Too small: frames without noise make the normal
  // equations singular. Too large: sigma is more than the error on very good sensors.
  double noise_floor = 1e-4;

  // What a real skin deviates, ring by ring, of mu p; 0 … 0.1. Too small: real skins are refused. Too large:
  // other histories pass.
  double uneven_share = 0.02;
  // Sigma of Gamma of a frame that only such a skin explains; Gamma, 0 … 0.2. Too small: sigma is less than
  // the error. Too large: such frames are wasted.
  double uneven_sigma = 0.03;
  // Mean square residual over rings from which on a frame needs such a skin, or has another history; 1.5 …
  // 20, about 1 where the model holds. Too small: frames are refused. Too large: a regrip passes.
  double max_ring_misfit = 4;
  // Residual pressure counts from this many standard deviations of its sum of squares on; 1 … 10. Too small:
  // noise widens sigma. Too large: a tilted contact passes for a round one.
  double clear_sigmas = 4;
  // Sigma of Gamma over that residual as a share of the peak; 0 … 5. Too small: sigma is less than the error
  // on contacts that are not Hertz's. Too large: it is more.
  double pressure_sigma = 0.9;
  // Friction's relative sigma over Gamma's for both causes above; 0 … 5. Too small and too large: as above.
  double friction_sigma_factor = 2;
  // Sigma of Gamma, of 1 - Gamma, below which friction is given by the parabola; 0.1 … 1. Too small: friction
  // is given late. Too large: its sigma is not meant.
  double max_friction_share = 0.5;

  // Sigma of Gamma beyond which the whole profile is weighed with the prior; Gamma, 0.005 … 0.3. Too small:
  // costs time. Too large: a parabola stands for a likelihood that is none.
  double open_sigma = 0.04;
  // The least share of a profile's evidence that is kept for what place and size leave open; 0.01 … 1. Too
  // small: profiles of small contacts say nothing. Too large: they say too much.
  double min_profile_share = 0.1;
  // The least traction ratio of a profile's point; 1e-9 … 1e-3. Keeps its friction above 0.
  double min_traction_ratio = 1e-6;
};

class Fit final : public SlipMethod {
 public:
  // friction_expected: the scene's range; decides only where the frame itself leaves the margin open.
  Fit(const TaxelLayout& layout, Range friction_expected, const FitOptions& options = {});
  Method name() const noexcept override { return Method::fit; }
  MethodSettings settings() const noexcept override {
    // Lists below, two residuals and their slopes a taxel, and the dome sheet's.
    constexpr std::size_t kNumbersATaxel = 2 + 6 + 8 + 2 * (kUnknowns + 1) + 7;
    return {.memory_bytes = sizeof(*this) + kNumbersATaxel * sizeof(double) * layout_.size()};
  }

  // Levenberg-Marquardt from the moments' start, at most kMostSteps steps. Not in the model if it did not
  // converge or if the residual is more than noise and the skin's unevenness explain.
  FrameEstimate estimate(const Frame& frame, const ContactPatch& patch) noexcept override;

  // Layouts of at most so many taxels are read as a whole, and over time (FrictionFilter). Checked with
  // `sliplab tradeoff`. Too small: 6 x 6 taxels give margins of their own that mean little. Too large: 8 x 8
  // taxels lose theirs.
  static constexpr std::size_t kFewTaxels = 40;
  // Bounds the time of a frame. Too small: frames near no load do not converge. Too large: the longest frame
  // takes longer.
  static constexpr int kMostSteps = 15;
  int steps() const noexcept { return steps_; }  // that the last frame took

 private:
  enum Unknown { center_x, center_y, radius, height, load, margin, kUnknowns };
  using Vector = Eigen::Matrix<double, kUnknowns, 1>;
  using Square = Eigen::Matrix<double, kUnknowns, kUnknowns>;

  struct Minimum {
    Vector at;
    Square hessian;
    bool converged = false;
  };

  void collect(const ContactPatch& patch) noexcept;
  Vector start(const ContactPatch& patch, const MomentRatio& ratio) const noexcept;
  // Half the squared residuals in units of noise, their gradient and Gauss-Newton's Hessian.
  double evaluate(const Vector& at, Vector& gradient, Square& hessian) noexcept;
  Minimum minimise(const Vector& start) noexcept;
  // Gamma, friction, place and radius with their deviations by the parabola; false if there is none.
  bool describe(const ContactPatch& patch, const Minimum& minimum, FrameEstimate& out) const noexcept;
  // Mean square residuals over rings: in units of noise, and of noise and an uneven skin.
  struct RingMisfit {
    double by_noise = 0;
    double by_skin = 0;
  };
  RingMisfit ring_misfit(const Vector& at) const noexcept;
  double residual_pressure(const Vector& at) const noexcept;
  double profile_share(const Square& hessian) const noexcept;
  void weigh_by_prior(const Vector& at, const Square& hessian, FrameEstimate& out) noexcept;

  TaxelLayout layout_;
  FitOptions options_;
  FrictionPrior prior_;
  contact::DomeSheet sheet_;
  std::size_t count_ = 0;
  double noise_normal_ = 1, noise_shear_ = 1;
  int steps_ = 0;
  std::vector<double> x_, y_, p_, q_, u_, v_;
  Eigen::Matrix<double, Eigen::Dynamic, kUnknowns>
      slopes_;  // of each residual, pressures first, by each unknown
  Eigen::VectorXd residuals_;
  struct Sheet {
    std::vector<double> value, d_x, d_u, d_v;
  } outer_, inner_;
};

}  // namespace slipd
