// The margin by a frame's whole profile where noise leaves it open: the likelihood is then no parabola about
// the best fit (docs/methods.md §23.4). Shared by the fits. Estimate thread; nothing allocates.
#pragma once

#include <array>

#include "core/reading/method/friction_prior.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

// The least traction ratio of a profile's point: its logarithm stays finite.
inline constexpr double kLeastTraction = 1e-6;

// The friction that each margin of a profile would need.
using ProfileFriction = std::array<double, MarginProfile::kSteps>;

// Fills gamma, sigma, friction and friction_sigma of `out` with means and deviations of the likelihood of
// each margin, times the prior of the friction that it would need. out.profile.misfit is filled up to a
// constant; that is taken off, so that its least is 0, and the profile is known.
void weigh_profile(const ProfileFriction& friction, const FrictionPrior& prior, Reading& out) noexcept;

}  // namespace slipd
