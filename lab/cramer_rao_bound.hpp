// The Cramér–Rao bound of the margin from one frame: the least standard deviation of any unbiased estimator,
// for Gaussian noise of the same variance and the six unknowns of a contact (centre, radius, pressure,
// friction, margin). It is approximate: the real noise is uniform, and the margin is known to lie in 0 … 1.
#pragma once

#include "core/contact/history.hpp"
#include "core/contact/scene.hpp"
#include "core/contact/scene_draws.hpp"
#include "core/frame/layout.hpp"
#include "paper/validation/trial_frames.hpp"

namespace lab {

// The bound of a contact at `gamma` in (0, 1) under monotonic loading; infinite where the frame contains no
// information on gamma. noise: half-width of uniform noise, as a fraction (see NoiseKind).
double cramer_rao_sigma(const slipd::TaxelLayout& layout, const slipd::contact::BodyPair& pair,
                        const slipd::ContactDraw& draw, double gamma, slipd::NoiseKind kind, double noise);

// The mean over contacts of a scene as measure_tradeoff draws them. The prior (gamma uniform in 0 … 1) counts
// as one more observation.
struct CramerRaoBound {
  double mean_error;     // mean |error| of the margin
  double class_correct;  // share of frames whose class is correct
};
CramerRaoBound mean_cramer_rao_bound(const slipd::TaxelLayout& layout, const slipd::Scene& scene,
                                     slipd::NoiseKind kind, double noise, std::size_t contacts,
                                     std::uint64_t seed);

}  // namespace lab
