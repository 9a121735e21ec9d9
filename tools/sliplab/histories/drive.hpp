// A grasp in frame time: contact with its memory → taxels → noise → the whole estimator chain → tallies.
#pragma once

#include <array>
#include <functional>

#include "core/estimate/chain.hpp"
#include "core/estimate/trial_frames.hpp"
#include "tools/sliplab/histories/grasp.hpp"
#include "tools/sliplab/tally.hpp"

namespace sliplab {

struct Sensing {
  slipd::NoiseKind kind = slipd::NoiseKind::sensor;
  double noise = 0.01;  // half-width, a fraction of the frame's largest pressure
  double frame_s = 0.005;
  // Whether the estimator gets the frame of this number, from 1; empty: it gets them all.
  std::function<bool(std::uint64_t)> comes = {};
};

struct Moment {
  double time_s;
  Move move;
  double normal_n, shear_n;  // N, shear signed
  slipd::Truth truth;
  slipd::Estimate estimate;  // of this frame, or of the last one that came
  double taken_us;           // by the estimate, processor time; 0 for a frame that did not come
};
using ByMove = std::array<Tally, kMoves>;

// `chain` is new. Only frames that come are tallied. `watch` may be empty; it sees every frame of contact.
ByMove drive(const Grasp& grasp, const slipd::TaxelLayout& layout, const slipd::Skin& skin,
             const Sensing& sensing, const slipd::RandomStream& noise, slipd::EstimatorChain& chain,
             const std::function<void(const Moment&)>& watch = {});

}  // namespace sliplab
