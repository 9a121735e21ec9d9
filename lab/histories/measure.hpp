// Random grasps through the whole chain of one method on one layout, counted by what the gripper does.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/contact/scene.hpp"
#include "lab/collect.hpp"
#include "lab/frames/random_frames.hpp"
#include "lab/tally/block_share.hpp"
#include "lab/tally/tally.hpp"

namespace lab {

// What the scene gives the estimator of a grasp's friction, which stays constant unless it is `none`.
enum class GivenFriction : std::uint8_t { none, constant, range, value };

struct HistoriesSetup {
  std::size_t grasps = 400;  // for each layout and method
  double skin_mm = 0;        // depth of the taxels
  double depth_taken = 1;    // the chain's, over that
  GivenFriction friction = GivenFriction::none;
  // What the skin lies on, and what the chain takes it to lie on.
  slipd::SkinBase base = slipd::SkinBase::half_space, base_taken = slipd::SkinBase::half_space;
  Sampling sensing;
  unsigned threads = 2;
};

using TalliesByMove = std::array<Tally, kMoves>;

struct HistoriesLine {
  std::size_t side = 0;
  std::string method;
  Tally all;
  TalliesByMove by_move{};
  // Of `all`, of frames with a gamma_low those where it is above the truth, and clearly above; a block is a
  // grasp.
  BlockShare low_above{}, low_clearly_above{};
  std::string first_grasp;  // its frames as CSV
  std::size_t unit = 0;     // number of its side and method in the sweep
};

// Frames of the move `unseen` are not in `all`.
HistoriesLine measure_moves(std::size_t side, const std::string& method, const HistoriesSetup& setup,
                            std::uint64_t seed, const Done& done);

}  // namespace lab
