// Simulates one grasp in frame time: contact with its load history → taxels → noise → the whole estimator
// chain → error statistics.
#pragma once

#include <array>
#include <functional>

#include "core/chain/chain.hpp"
#include "lab/error_statistics.hpp"
#include "lab/histories/grasp.hpp"
#include "paper/validation/trial_frames.hpp"

namespace lab {

struct Sampling {
  slipd::NoiseKind kind = slipd::NoiseKind::sensor;  // what the noise is a fraction of
  double noise = 0.01;                               // half-width, a fraction of the frame's largest pressure
  double frame_s = 0.005;                            // time from frame to frame, s
  double stretch = 1, power = 2;                     // the contact's shape, see contact::Imprint
  // Whether the estimator receives the frame of this number, from 1; empty: it receives all.
  std::function<bool(std::uint64_t)> comes = {};
  // Changes a frame before the estimator receives it; empty: frames are as sensed.
  std::function<void(slipd::FrameSlot&)> spoil = {};
  // Whether to find out for each frame if a change of friction shows in it (GraspSample::traced).
  bool trace = false;
};

struct GraspSample {
  double time_s;             // since the grasp began
  Move move;                 // what the gripper does
  double normal_n;           // normal force, N
  double shear_n;            // tangential force, N, signed
  slipd::Truth truth;        // of the contact
  slipd::Estimate estimate;  // of this frame, or of the last one that the estimator received
  bool traced;      // false while friction has changed and no frame has shown it; see Sampling::trace
  double taken_us;  // processor time of the estimate, us; 0: the estimator did not receive the frame
};
using StatisticsByMove = std::array<ErrorStatistics, kMoves>;

// A chain for the paper's contacts on a square grid of `side` by `side` taxels, up to 2 mm off its middle;
// the pad is 16 mm wide, that of 4 x 4 has the pitch of commercial fingertips. `noise`: as in Sampling.
slipd::ChainSetup paper_chain(std::size_t side, slipd::MethodChoice method, double noise);

// `skin`: of the sensor; its depth_m is what is felt, whatever the chain's is. No trace is kept under a skin.
// `chain` must be new. Statistics count only frames that the estimator received. `watch` can be empty; it is
// called for every frame of contact.
StatisticsByMove drive(const Grasp& grasp, const slipd::TaxelLayout& layout, const slipd::Skin& skin,
                       const Sampling& sensing, const slipd::RandomStream& noise,
                       slipd::EstimatorChain& chain,
                       const std::function<void(const GraspSample&)>& watch = {});

}  // namespace lab
