// The depth of the taxels as one more unknown of SubsurfaceFit, with what was known of it before.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/reading/fit/subsurface_fit.hpp"

namespace slipd {

namespace {

using Model = ContactShape;

}  // namespace

// Where the depth is known, few frames are asked.
void SubsurfaceFit::begin_depth() noexcept {
  constexpr int kSkipped = 7;
  frame_.depth_asked = depth_.open() && (!depth_.settled() || ++unasked_ > kSkipped);
  if (frame_.depth_asked) unasked_ = 0;
}

double SubsurfaceFit::depth_precision() const noexcept {
  return frame_.depth_asked ? 1 / (depth_.now().sigma * depth_.now().sigma) : Model::kHeldDepth;
}

void SubsurfaceFit::evaluate(const Full& at, int unknowns, Model::Normal& normal) noexcept {
  model_.evaluate(at, unknowns, normal);
  weigh_depth(at, normal);
}

void SubsurfaceFit::weigh_depth(const Full& at, Model::Normal& normal) const noexcept {
  const double precision = depth_precision(), off = at[Model::depth] - depth_.now().mean;
  normal.cost += 0.5 * precision * off * off;
  normal.gradient[Model::depth] += precision * off;
  normal.hessian(Model::depth, Model::depth) += precision;
}

// With H of the unknowns without the depth and h what couples them to it, they follow it by -H^-1 h, and what
// that leaves of its own information is what the frame shows of it. Then the depth is held.
void SubsurfaceFit::take_depth(Minimum& best) noexcept {
  Square& hessian = best.normal.hessian;
  Vector coupled = hessian.col(Model::depth);
  const double known = coupled[Model::depth];
  coupled[Model::depth] = 0;
  hessian(Model::depth, Model::depth) = Model::kHeldDepth;
  if (!frame_.depth_asked || !best.converged) return;
  const Vector follow = -hessian.ldlt().solve(coupled);
  const double information = known + coupled.dot(follow);
  if (!(information > 0)) return;
  margin_by_depth_ = follow[Model::margin];
  depth_.take(depth_.limited({best.at[Model::depth], 1 / std::sqrt(information)}));
}

}  // namespace slipd
