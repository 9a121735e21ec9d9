// How near to the margin any unbiased reading of one frame can come: the Cramér–Rao bound for Gaussian noise
// of the same spread, over the six unknowns of a contact (centre, radius, pressure, friction, margin). A
// guide: real noise is bounded, and the margin is known to lie in 0 … 1 before anything is seen.
#pragma once

#include "core/contact/history.hpp"
#include "core/contact/scene.hpp"
#include "core/estimate/trial_frames.hpp"
#include "core/frame/layout.hpp"
#include "core/model/dataset.hpp"

namespace sliplab {

// Standard deviation of the margin of a contact at `gamma` in (0, 1) whose load rose; infinite where the
// frame does not tell. noise: half-width of uniform noise, as a fraction (see NoiseKind).
double limit_sigma(const slipd::TaxelLayout& layout, const slipd::contact::BodyPair& pair,
                   const slipd::ContactDraw& draw, double gamma, slipd::NoiseKind kind, double noise);

// The mean over contacts of a scene as measure_tradeoff draws them, with what is known beforehand (Gamma
// uniform in 0 … 1) as one more reading.
struct Limit {
  double mean_error, right;
};
Limit limit_of(const slipd::TaxelLayout& layout, const slipd::Scene& scene, slipd::NoiseKind kind,
               double noise, std::size_t contacts, std::uint64_t seed);

}  // namespace sliplab
