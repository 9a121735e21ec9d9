// The depth of the taxels as one more unknown of ImprintFit, with what was known of it before.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/estimate/imprint_fit.hpp"

namespace slipd {

// By one more evaluation at another depth: with r the residuals and J their slopes by the unknowns, r_d by
// the log of the depth, the unknowns follow it by -H^-1 J^T r_d, and what that leaves of r_d shows the depth.
ImprintFit::DepthSlope ImprintFit::depth_slope(const Minimum& best) noexcept {
  constexpr double kStep = 0.03;  // of the log of the depth
  const std::size_t rows = 3 * model_.count();
  const auto residuals = model_.residuals();
  std::copy(residuals.begin(), residuals.end(), unsheared_.begin());
  const double depth_m = model_.depth_m();
  ImprintModel::Normal other;
  model_.set_depth(depth_m * std::exp(kStep));
  model_.evaluate(best.at, unknowns(), other);
  model_.set_depth(depth_m);
  double squares = 0, score = 0;
  const auto moved = model_.residuals();
#pragma omp simd reduction(+ : squares, score)
  for (std::size_t i = 0; i < rows; ++i) {
    const double slope = (moved[i] - unsheared_[i]) / kStep;
    squares += slope * slope;
    score += slope * unsheared_[i];
  }
  const Vector by_depth = (other.gradient - best.normal.gradient) / kStep;
  DepthSlope slope;
  slope.unknowns = -best.normal.hessian.ldlt().solve(by_depth);
  slope.information = squares + by_depth.dot(slope.unknowns);
  slope.score = score + best.normal.gradient.dot(slope.unknowns);
  return slope;
}

// Steps of Gauss and Newton's method, and where one is long for the unknowns the fit anew from there. A step
// that is long for the depth is taken again from its end.
void ImprintFit::fit_depth(Minimum& best) noexcept {
  if (!depth_.open()) return;
  // Where it is known, few frames are asked.
  constexpr int kSkipped = 7, kSteps = 3;
  constexpr double kLongStep = 0.05;  // of the log of the depth
  if (depth_.settled() && ++unasked_ <= kSkipped) return;
  margin_by_depth_ = 0;
  unasked_ = 0;
  LogDepth known = depth_.now();
  double here = known.mean;
  for (int i = 0; i < kSteps && best.converged; ++i) {
    const DepthSlope slope = depth_slope(best);
    best.current = false;
    if (!(slope.information > 0)) break;
    known = depth_.with({here - slope.score / slope.information, 1 / std::sqrt(slope.information)});
    margin_by_depth_ = slope.unknowns[ImprintModel::margin];
    const double further = known.mean - here;
    const Vector step = further * slope.unknowns;
    here = known.mean;
    model_.set_depth(depth_.depth_m(here));
    best.at = stepped(best.at, step);
    if (step.dot(best.normal.hessian * step) > options_.refit_sigmas * options_.refit_sigmas) {
      minimise(unknowns(), best);
      weights_change(unknowns(), best);
    }
    refresh(unknowns(), best);
    if (std::fabs(further) < kLongStep) break;
  }
  refresh(unknowns(), best);
  depth_.take(known);
}

}  // namespace slipd
