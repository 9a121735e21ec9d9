// The one driver of grasps: plays the frames of any generator through estimator chains, in frame time.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "core/chain/chain.hpp"
#include "lab/frames/grasp_frames.hpp"

namespace lab {

// A frame, and what the chains made of it.
struct GraspSample {
  const GraspMoment& at;
  // Of each chain, of this frame; or of the last frame that the chains received.
  std::span<const slipd::Estimate> estimates;
  // Processor time of each estimate, us.
  std::span<const double> taken_us;
  bool received;  // the frame came to the chains
  bool traced;    // false while friction has changed and no frame has shown it; see DriveOptions

  const slipd::Estimate& estimate() const { return estimates.front(); }
};

struct DriveOptions {
  // Whether the chains receive the frame of this number, from 1; empty: they receive all.
  std::function<bool(std::uint64_t)> comes = {};
  // Whether to find out for each frame if a change of friction shows in it, of frames that can be traced.
  bool trace = false;
};

// Chains must be new. `watch` is called for every frame.
void drive(GraspFrames& frames, std::span<slipd::EstimatorChain> chains,
           const std::function<void(const GraspSample&)>& watch, const DriveOptions& options = {});
void drive(GraspFrames& frames, slipd::EstimatorChain& chain,
           const std::function<void(const GraspSample&)>& watch, const DriveOptions& options = {});

}  // namespace lab
