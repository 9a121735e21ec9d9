// Maximum likelihood (docs/theory.md §10): the contact model itself, averaged over every taxel, fitted to
// pressure and shear together. The slowest way to the margin and the one that comes near what the noise
// allows (the Cramér–Rao bound, §10.3), on any layout, with part of the contact beyond the sensor's edge, or
// with taxels dead.
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
#include "core/estimate/method.hpp"
#include "core/estimate/moments.hpp"

namespace slipd {

class Fit final : public SlipMethod {
 public:
  // friction_expected: the scene's range; decides only where the frame itself leaves the margin open.
  Fit(const TaxelLayout& layout, Range friction_expected);
  Method name() const noexcept override { return Method::fit; }
  MethodSettings settings() const noexcept override {
    // Lists below, two residuals and their slopes a taxel, and the dome sheet's.
    constexpr std::size_t kNumbersATaxel = 2 + 6 + 8 + 2 * (kUnknowns + 1) + 7;
    return {.memory_bytes = sizeof(*this) + kNumbersATaxel * sizeof(double) * layout_.size()};
  }

  // Levenberg-Marquardt from the moments' start, at most kMostSteps steps. Not in the family if it did not
  // converge or if what is left over is more than noise and the skin's unevenness explain.
  FrameEstimate estimate(const Frame& frame, const ContactPatch& patch) noexcept override;

  static constexpr std::size_t kFewTaxels = 40;  // layouts this small are read over time, see FrictionFilter
  static constexpr int kMostSteps = 15;
  int steps() const noexcept { return steps_; }  // that the last frame took

 private:
  enum Unknown { center_x, center_y, radius, height, load, margin, kUnknowns };
  using Vector = Eigen::Matrix<double, kUnknowns, 1>;
  using Square = Eigen::Matrix<double, kUnknowns, kUnknowns>;

  void collect(const ContactPatch& patch) noexcept;
  Vector start(const ContactPatch& patch, const MomentRatio& ratio) const noexcept;
  // Half the squared residuals in units of noise, their gradient and Gauss-Newton's Hessian.
  double evaluate(const Vector& at, Vector& gradient, Square& hessian) noexcept;
  // Mean squares over rings of what is left over: in units of noise, and of noise and an uneven skin.
  struct RingMisfit {
    double by_noise = 0, by_skin = 0;
  };
  RingMisfit ring_misfit(const Vector& at) const noexcept;
  double pressure_left_over(const Vector& at) const noexcept;
  static double share_left_open(const Square& hessian) noexcept;
  void weigh_by_scene(const Vector& at, const Square& hessian, FrameEstimate& out) noexcept;

  TaxelLayout layout_;
  Range expected_;
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
