// A step of Levenberg and Marquardt's method where one unknown has bounds.
#pragma once

#include <Eigen/Cholesky>
#include <algorithm>

namespace slipd {

// The step s with the least g's + s'Hs/2, where H is `hessian` with its diagonal times 1 + damping, g
// `gradient`, and s[bounded] is from `least` to `most`. Where the free step leaves the bounds, the quadratic
// is convex and has its least on the bound that it passes; the others then take the step that suits. To cut
// the free step instead would leave them where no damping finds the way on: a frame whose margin is at a
// bound never converged. hessian: symmetric, positive definite once damped; any unit. Not finite if it is
// singular. No allocation for matrices with a fixed greatest size.
template <typename Square, typename Vector>
Vector bounded_step(Square hessian, const Vector& gradient, double damping, Eigen::Index bounded,
                    double least, double most) noexcept {
  hessian.diagonal() *= 1 + damping;
  const Vector free = -hessian.ldlt().solve(gradient);
  if (free[bounded] >= least && free[bounded] <= most) return free;
  const double held = std::clamp(free[bounded], least, most);
  Vector others = -(gradient + held * hessian.col(bounded));
  hessian.row(bounded).setZero();
  hessian.col(bounded).setZero();
  hessian(bounded, bounded) = 1;
  others[bounded] = held;
  return hessian.ldlt().solve(others);
}

}  // namespace slipd
