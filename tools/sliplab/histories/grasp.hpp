// Random grasps: what a gripper does to an object between closing and letting go, as straight pieces in force
// and friction. A grasp is a pure function of its seed and number.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/contact/scene.hpp"
#include "core/model/dataset.hpp"
#include "core/numeric/random.hpp"

namespace sliplab {

enum class Move : std::uint8_t {
  grip,      // P from nothing, no shear
  load,      // Q rises in the direction it has
  slide,     // Q beyond mu P: gross slip
  unload,    // Q falls, not to nothing
  reverse,   // Q to the other sign
  tighten,   // P up at constant Q: a regrip
  loosen,    // P down at constant Q
  together,  // P and Q up, the increment stuck
  falls,     // friction falls at once, then held
  rises,     // friction rises at once, then loaded on
  hold,      // nothing moves
  unseen     // friction rises under a held object, which no sensor feels; the last, counted apart
};
inline constexpr std::size_t kMoves = 12;
std::string_view name_of(Move move) noexcept;

struct Piece {
  Move move;
  double normal_n, shear_n;  // at its end; shear signed
  double friction;           // from its begin on
  double seconds;
};

struct Grasp {
  slipd::ContactDraw contact;  // friction and normal force of the begin
  double direction_rad = 0;    // the direction of the shear
  std::vector<Piece> pieces;
};

// Grip, load, and `moves` more that are drawn: load 3, tighten and unload 2, all others 1 in 14, each lasting
// 40 to 400 ms; at last `unseen`. Normal force and friction stay within what the contact's family expects.
Grasp draw_grasp(const slipd::Scene& scene, std::uint64_t seed, std::size_t index, std::size_t moves = 8);

}  // namespace sliplab
