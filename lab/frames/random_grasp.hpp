// Random grasps: the loads on an object from grip to release, piecewise linear in force, piecewise constant
// in friction. A grasp is a pure function of its seed and number.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/contact/scene.hpp"
#include "core/contact/scene_draws.hpp"
#include "core/numeric/random.hpp"

namespace lab {

enum class Move : std::uint8_t {
  grip,      // P rises from 0, no shear
  load,      // Q rises in its present direction
  slide,     // Q beyond mu P: gross slip
  unload,    // Q falls, but not to 0
  reverse,   // Q changes its sign
  tighten,   // P rises at constant Q: a regrip
  loosen,    // P falls at constant Q
  together,  // P and Q rise; the increment causes no slip
  falls,     // friction falls in a step; then the load is constant
  rises,     // friction rises in a step; then Q rises
  hold,      // the load is constant
  unseen     // friction rises at constant load, which no sensor can observe; the last move, counted apart
};
inline constexpr std::size_t kMoves = 12;
std::string_view name_of(Move move) noexcept;

struct LoadSegment {
  Move move;
  double normal_n;  // normal force at the end, N
  double shear_n;   // tangential force at the end, N, signed
  double friction;  // coefficient of friction, from the begin on
  double seconds;   // duration
};

struct Grasp {
  slipd::ContactDraw contact;  // the contact with its initial friction and normal force
  double direction_rad = 0;    // direction of the shear in the sensor's plane
  std::vector<LoadSegment> segments;
};

// Grip, load, then `moves` random moves, each of 40 to 400 ms, then `unseen`. Of 14 moves 3 are load, 2
// tighten, 2 unload, and 1 each of the others. Normal force and friction stay within the ranges of the
// contact's family.
Grasp draw_grasp(const slipd::Scene& scene, std::uint64_t seed, std::size_t index, std::size_t moves = 8);

}  // namespace lab
