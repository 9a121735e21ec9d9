// What the parabola about a fit's minimum says of margin and friction: the same for every fit, whatever else
// it has as unknowns (docs/methods.md §23). Estimate thread; nothing allocates.
#pragma once

#include <cmath>
#include <limits>

#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"
#include "core/numeric/scaled_inverse.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

// Square: a matrix as ScaledInverse takes it.
template <class Square>
class MarginParabola {
 public:
  // information: of all unknowns, from Gauss and Newton's Hessian in units of noise. margin, load: which of
  // them are Gamma and Q/P.
  MarginParabola(const Square& information, int margin, int load) noexcept
      : inverse_(information),
        load_(load),
        variance_(inverse_.variance(margin)),
        held_variance_(1 /
                       (information(margin, margin) -
                        information(load, margin) * information(load, margin) / information(load, load))) {}

  // Gamma, friction and their deviations into `out`; false, and nothing, without a clear load.
  bool describe(double gamma, double load, Reading& out) const noexcept {
    if (!std::isfinite(variance_)) return false;
    const double load_sigmas = load / std::sqrt(inverse_.variance(load_));
    if (!(load_sigmas > kClearSigmas)) return false;
    const double utilisation = 1 - gamma;
    out.gamma = gamma;
    out.sigma = load_sigmas > kStrongSigmas ? std::sqrt(variance_) : 1;
    out.friction = load / utilisation;
    out.friction_sigma = out.sigma < kKnownFrictionShare * utilisation
                             ? out.friction * norm(out.sigma / utilisation, 1 / load_sigmas)
                             : std::numeric_limits<double>::infinity();
    return true;
  }

  // A profile of margins holds all but margin and load as they fit best, and they are not known so well: the
  // margin's variance with them held, over that with them free; 0 … 1.
  double profile_share() const noexcept {
    const double share = held_variance_ / variance_;  // not a number where nothing shows the margin
    return share > 0 && share < 1 ? share : 1;
  }

 private:
  ScaledInverse<Square> inverse_;
  int load_;
  // Of the margin: with all unknowns free, and with all but the load held.
  double variance_, held_variance_;
};

}  // namespace slipd
