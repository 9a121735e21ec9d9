// The margin by a frame's whole profile where noise leaves it open: the likelihood is then no parabola about
// the best fit (docs/methods.md §23.4). Shared by the fits. Estimate thread; nothing allocates.
#pragma once

#include <array>

#include "core/reading/method/friction_prior.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

// The shear of a frame beside what each margin of a profile would make of one Q/P, sums over all samples in
// units of noise: of the second one's squares, and of the products of both.
struct ProfileSums {
  std::array<double, MarginProfile::kSteps> squares, products;
};

// Fills the profile of `out`, each margin with the load that suits it best, and gamma, sigma, friction and
// friction_sigma with means and deviations of the likelihood of each margin, times the prior of the friction
// that it would need. share: by which the profile is flatter, as all else is held in it; 0 … 1.
void weigh_profile(const ProfileSums& sums, double share, const FrictionPrior& prior, Reading& out) noexcept;

}  // namespace slipd
