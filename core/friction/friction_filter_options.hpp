// Every threshold of FrictionFilter (docs/methods.md §28).
#pragma once

#include <cstddef>

#include "core/friction/followed_forces.hpp"
#include "core/friction/friction_grid.hpp"
#include "core/friction/history_state.hpp"
#include "core/friction/traction_ratio.hpp"

namespace slipd {

// Sigmas are standard deviations of a force's noise in the same frame. A residual is what a frame shows less
// what a friction expects of it; squared residuals are in units of their variance, so that half of one is a
// nat of likelihood. Shares are dimensionless. Checked with `slipd-lab histories --grasps 400`; fields of
// force-only sensors with `slipd-lab tradeoff --layouts 4,wrench`, rows over time.
struct FrictionFilterOptions {
  FrictionGridOptions grid;
  TractionRatioOptions traction_ratio;
  FollowedForcesOptions forces;
  HistoryOptions history;

  // Points of the grid where frames have a shape, each with a Winkler foundation of its own; 16 …
  // WinklerFoundations::kMost. Too few: the right friction lies between two. More cost time in proportion.
  std::size_t foundations = 56;
  // Points of the grid of a force-only sensor, which has no foundations; 16 … FrictionGrid::kMost. Too few:
  // friction known by a slide changes in steps.
  std::size_t force_only_points = FrictionGrid::kMost;

  // Time after which evidence of a force-only sensor has faded to 1/e; s, 0.5 … 100. Too small: friction is
  // forgotten between two slides. Too large: friction that changed unseen is given for longer.
  double forget_s = 5;
  // Shear from which on a frame is weighed; sigmas, 3 … 20. Too small: noise is weighed, and shows a friction
  // that no object has. Too large: friction is learnt late, on few taxels above all.
  double min_shear_sigmas = 10;

  // Sigma of a frame's margin up to which it confirms that a load which was not seen was monotonic; Gamma,
  // 0.05 … 0.5. Too small: such a grasp gets no margin while its load is light. Too large: frames whose noise
  // some friction always explains confirm a history that is wrong.
  double confirming_sigma = 0.2;

  // Evidence that one margin profile, or one frame of a slide, counts for; frames, 0.1 … 1. Less than 1,
  // since neighbouring frames share the skin's unevenness. Too small: learns slowly. Too large: sigma is less
  // than the error.
  double frame_share = 0.5;
  // Discount of profiles in a row: noise of the contact's place and size draws all of them the same way.
  // After frames of sigmas s_i the next one counts for 1/(1 + sum (s_i/alike_sigma)^2); sigma of Gamma, 0.3 …
  // 5. Too small: learns slowly. Too large: sigma is less than the error.
  double alike_sigma = 1.2;
  // Share by which forces have to move, of the normal force and of the friction limit, for a frame's error to
  // be another one to 1/e; 0.05 … 5. Too small: sigma is less than the error after a hold. Too large: learns
  // slowly.
  double parting_share = 0.5;
  // Gain of the mean, frame by frame, of the sigma that frames have in common; 0.02 … 0.5. Too small: after a
  // change of load few frames count for too much or too little. Too large: frames whose noise shows less
  // friction weigh more than others.
  double common_gain = 0.2;
  // The least share of a frame's variance that is noise, and the least 1 - Gamma that friction is read from;
  // 1e-6 … 0.1 each. They keep quotients finite, without noise and without load.
  double min_noise_share = 1e-4;
  double min_mobilised = 1e-3;
  // Standard deviation of a margin that lies between two points of the grid, of its step; 0 … 1. Too small:
  // a sharp frame refutes the points on both sides of the right friction. Too large: sharp frames are wasted.
  double grid_share = 0.35;

  // How far the slip moment of the likeliest friction's foundation may be from a monotonic load's and still
  // count as one: a share of Q, plus a share of mu P; 0.01 … 0.1 and 0.001 … 0.01. Too small: a monotonic
  // load counts as a general one, and frames by themselves say nothing. Too large: traction of a small
  // unloading is overlooked.
  double monotonic_share_of_shear = 0.03;
  double monotonic_share_of_limit = 0.003;

  // Standard deviation of what such a load adds to a frame's margin, of that; 0 … 1. Methods differ in how
  // much of it they read. Too small: sigma is less than the error after a small regrip or unloading. Too
  // large: frames that say much are wasted.
  double offset_sigma_share = 0.3;
  // Points of the grid on either side of the likeliest friction for which it is computed by their own
  // contacts; 0 … foundations. Too few: a friction that is not known yet is learnt with the likeliest one's
  // history. More cost time.
  std::size_t offset_reach = 2;

  // What the shear moments of a real skin deviate from the model, of the shear; 0.005 … 0.1. Too small: the
  // model's error refutes the right friction. Too large: frictions are not distinguished.
  double uneven_share = 0.02;
  // How well noisy forces reproduce the locked-in traction, of the larger shear moment; 0 … 0.2. Too small
  // and too large: as above, after an unloading.
  double locked_in_share = 0.04;
  // Standard deviation that the model leaves beyond that, of the sum of both; 0.1 … 1. Too small: one frame
  // decides. Too large: learns slowly.
  double model_sigma_share = 0.5;

  // Frames are clean if noise of the shear moments is below this, of what the model leaves open; 0 … 1. In
  // clean frames a low friction can be looked for. Too small: friction that fell is learnt late. Too large:
  // noise is taken for a fall.
  double clean_share = 0.4;
  // Mean residual of the likeliest friction that casts doubt on it, of what the model leaves open: in clean
  // frames, in others; 0.5 … 3. Too small: sigma is wide without a reason. Too large: margins of a friction
  // that has fallen are given as sure.
  double doubt_share = 1;
  double noisy_doubt_share = 1.6;
  // Gain of the mean residual over noisy frames (1 in clean ones); 0.05 … 1. Too small: doubt comes late. Too
  // large: doubt comes from noise.
  double noisy_residual_gain = 0.2;
  // Frames that doubt lasts, until the weights have found another friction; frames, 1 … 100. Too small: the
  // first margins after a change are given as sure. Too large: sigma is wide for longer.
  int doubt_frames = 10;
  // Jump of the likeliest friction between two frames that casts doubt as well; log mu, 0.1 … 1. Too small:
  // learning casts doubt. Too large: a jump between two peaks is given as sure.
  double jump_log = 0.4;

  // The slip moment's step from one frame to the next that shows friction's fall: beyond what the likeliest
  // friction expects, by standard deviations of noise, 3 … 10, by a share of the forces' step, 0.005 … 0.5,
  // and of the shear, 0.002 … 0.05. Too small: noise, or a fast load, is taken for a fall, and no margin is
  // given. Too large: a fall between two frames is learnt late.
  double fall_sigmas = 4;
  double fall_share_of_step = 0.02;
  double fall_share = 0.003;
  // What then counts against each lower friction; nats, 0 … 5. Too small: the former friction, which may have
  // fallen by a little, is given up. Too large: the fall is learnt late.
  double fallen_nats = 0.5;

  // Least squared residual of all frictions above which a frame is an outlier and takes no weight; 4 … 50.
  // Too small: frames that say something are left out. Too large: frames that contradict the model decide.
  double outlier_residual = 9;
  // The most that one frame adds to the mean of those; > outlier_residual. Too large: one wild frame takes
  // the margin away for long.
  double max_residual = 36;
  // Memory of the mean of least squared residuals, frame by frame; 0 … 0.99. Too small: single frames take
  // the margin away. Too large: margins of a model that no longer fits are given for longer.
  double residual_memory = 0.9;
  // Mean of least squared residuals from which no margin is given; 1.5 … 9, about 1 where all is understood.
  double max_mean_residual = 4;
  // Squared residual of the likeliest friction from which the frame contradicts it; 9 … 50. Too small: sigma
  // is wide without a reason. Too large: friction that fell is given late.
  double surprising_residual = 16;
  // CUSUM (Page 1954) of half the likeliest friction's squared residuals: each frame counts less than it by
  // the drift, the sum ends at the threshold what older frames said of friction; nats, 1 … 10 and 3 … 50. Too
  // small: noise forgets friction. Too large: a change is learnt late.
  double cusum_drift_nats = 4;
  double cusum_threshold_nats = 8;

  // A shear that ends below min_shear_sigmas got there in steps of less than this from frame to frame, of mu
  // P; 0.2 … 1. A larger one is no unloading that was seen: the shear may have been lost. Too small: fast
  // unloadings get no margin. Too large: a channel that died unseen comes out as a grip without load.
  double max_lost_step = 0.45;
  // Frames with a clear shear in a row that may lack evidence of friction before older estimates are no
  // longer trusted; frames, 1 … 1000. Too small: gaps in a margin. Too large: margins from the past for
  // longer.
  int max_unverified_frames = 25;
  // Under a torque whose load has fallen memory answers while taxels carry less than this of the friction
  // that was learnt; 1.02 … 1.3. Too small: noise takes the margin away. Too large: friction that was learnt
  // too low is kept.
  double held_ratio = 1.1;

  // P that grows by more than this factor leaves what a lighter contact of a force-only sensor showed; 1.2 …
  // 10: a touch may hook, and its zero is a larger part of it. Too small: a regrip forgets friction. Too
  // large: the first touch bounds friction for long.
  double grown = 2;
  // What is kept of that evidence; share, 0 … 1.
  double kept_when_grown = 0.25;
  // Taxels that carry more than this of P against each other say nothing of friction
  // (FieldCourse::internal_share); share, 0.05 … 0.5. Quiet grasps of real pillars reach 0.066. Too small:
  // slides of a real skin say nothing. Too large: a hooked or turned contact is taken for friction.
  double max_internal_share = 0.1;
  // |Q|/P of a force-only sensor above this times the greatest expected friction is no friction: something
  // hooks; 1.2 … 5, and by how many standard deviations; 0 … 10. What it showed is forgotten, and nothing is
  // learnt until the load is below the least friction. Too small: an object of more friction than was
  // expected counts as hooked. Too large: a hook is learnt as friction.
  double exceeds_friction = 1.5;
  double exceeds_friction_sigmas = 3;
  // The most that one frame of a slide counts against a friction, as a squared residual; 4 … 100. Too small:
  // a slide does not refute what contradicts it. Too large: one false slide refutes the right friction.
  double max_slide_residual = 25;
};

}  // namespace slipd
