// Maximum likelihood: the contact model itself, averaged over every taxel, fitted to pressure and shear
// together (docs/methods.md §23). The method that costs most time, and the one that
// comes near what the noise allows (the Cramer-Rao limit), on any layout, with part of the contact beyond the
// sensor's edge, or with taxels dead. As method block-fit it reads taxels summed in square blocks, in a fifth
// of the time where a contact is many taxels wide (docs/methods.md §24).
//
// Unknown are the centre, the radius a, the pressure's height B = p0/a, the load T = Q/P and Gamma:
//   p = B A(a),   q = B T (A(a) - A(k a)) / (1 - Gamma),   k^3 = Gamma,   A(x) the average of sqrt(x^2 -
//   r^2).
// T and Gamma stay well apart at any load, where mu and k would not: near no load only mu (1 - k) is felt.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/contact/dome_lattice.hpp"
#include "core/contact/dome_sheet.hpp"
#include "core/contact/scene.hpp"
#include "core/frame/few_taxels.hpp"
#include "core/patch/square_blocks.hpp"
#include "core/reading/fit/fit_options.hpp"
#include "core/reading/fit/subsurface_fit.hpp"
#include "core/reading/method/friction_prior.hpp"
#include "core/reading/method/method.hpp"
#include "core/reading/moments/moments.hpp"

namespace slipd {

class Fit final : public SlipMethod {
 public:
  // friction_expected: the scene's range; decides only where the frame itself leaves the margin open.
  // skin_depth_m, skin_depth_sigma: how deep the taxels lie under the surface, m, and the standard deviation
  // of its log; bonded_poisson: what they lie on. See Skin.
  Fit(const TaxelLayout& layout, Range friction_expected, const FitOptions& options = {},
      double skin_depth_m = 0, double skin_depth_sigma = 0,
      std::optional<double> bonded_poisson = std::nullopt);
  // block_fit where taxels are summed in blocks.
  Method name() const noexcept override { return blocks_ ? Method::block_fit : Method::fit; }
  void forget() noexcept override { imprint_.forget(); }
  MethodSettings settings() const noexcept override {
    // Lists below, two residuals and their slopes a taxel, and the dome sheet's.
    constexpr std::size_t kNumbersATaxel = 2 + 6 + 8 + 2 * (kUnknowns + 1) + 7;
    return {.memory_bytes = sizeof(*this) + kNumbersATaxel * sizeof(double) * x_.size() +
                            (blocks_ ? blocks_->memory_bytes() + lattice_->memory_bytes() : 0) +
                            imprint_.memory_bytes()};
  }

  // Levenberg-Marquardt from the moments' start, at most kMostSteps steps. Not in the model if it did not
  // converge or if the residual is more than noise and the skin's unevenness explain.
  Reading estimate(const Frame& frame, const ContactPatch& patch) noexcept override;

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

  struct Sheet {
    std::vector<double> value, d_x, d_u, d_v;
  };
  void collect(const ContactPatch& patch) noexcept;
  void collect_blocks(const ContactPatch& patch, double along_radius) noexcept;
  void set_noise(const ContactPatch& patch) noexcept;
  // Of a dome of radius x about the centre of `at`.
  void fill_sheet(double x, const Vector& at, Sheet& out) noexcept;
  Vector start(const ContactPatch& patch, const MomentRatio& ratio) const noexcept;
  // Half the squared residuals in units of noise, their gradient and Gauss-Newton's Hessian.
  double evaluate(const Vector& at, Vector& gradient, Square& hessian) noexcept;
  Minimum minimise(const Vector& start, double converged_sigmas) noexcept;
  // On large blocks, then by one step on small ones.
  Minimum minimise_blocks(const ContactPatch& patch, const Vector& start) noexcept;
  // One step of Newton's method; the domes follow linearly. False if it is too long for that.
  bool take_last_step(Minimum& minimum) noexcept;
  // Gamma, friction, place and radius with their deviations by the parabola; false if there is none, or no
  // clear load.
  bool describe(const ContactPatch& patch, const Minimum& minimum, Reading& out) const noexcept;
  // Centre and radius of the contact into `out`.
  static void place(const ContactPatch& patch, const Vector& at, Reading& out) noexcept;
  // Mean square residuals over rings: in units of noise, and of noise and an uneven skin.
  struct RingMisfit {
    double by_noise = 0;
    double by_skin = 0;
  };
  RingMisfit ring_misfit(const Vector& at) const noexcept;
  double residual_pressure(const Vector& at) const noexcept;
  double profile_share(const Square& hessian) const noexcept;
  void weigh_by_prior(const Vector& at, const Square& hessian, Reading& out) noexcept;

  const TaxelLayout layout_;
  const FitOptions options_;
  const FrictionPrior prior_;
  // Both, or neither: taxels by themselves.
  std::optional<SquareBlocks> blocks_;
  std::optional<contact::DomeLattice> lattice_;
  contact::DomeSheet sheet_;  // of taxels by themselves
  SubsurfaceFit imprint_;     // contacts that are elliptic or under a skin
  const bool under_skin_;
  std::size_t count_ = 0;
  double noise_normal_ = 1, noise_shear_ = 1;
  int steps_ = 0;
  std::vector<double> x_, y_, p_, q_, u_, v_;
  Eigen::Matrix<double, Eigen::Dynamic, kUnknowns>
      slopes_;  // of each residual, pressures first, by each unknown
  Eigen::VectorXd residuals_;
  Sheet outer_, inner_;
};

}  // namespace slipd
