#include "lab/frames/random_grasp.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace lab {
namespace {

using slipd::RandomStream;
using slipd::Range;

constexpr double kShortestSeconds = 0.04, kLongestSeconds = 0.4;
constexpr double kSliding = 1.1;  // of mu P

constexpr std::array kDrawn{Move::load,     Move::load,   Move::load,  Move::tighten, Move::tighten,
                            Move::unload,   Move::unload, Move::slide, Move::reverse, Move::loosen,
                            Move::together, Move::falls,  Move::rises, Move::hold};

Range reach(Range all, Range more) {
  return {std::min(all.low, more.low), std::max(all.high, more.high)};
}

// One move, from the load at the end of the segment before. `u` gives random numbers in [0, 1) by their
// index.
LoadSegment next(Move move, const LoadSegment& from, const RandomStream& u, Range normal_n, Range friction) {
  LoadSegment to = from;
  to.move = move;
  to.seconds = kShortestSeconds * std::pow(kLongestSeconds / kShortestSeconds, u.uniform(0));
  const double sign = from.shear_n < 0 ? -1 : 1, part = u.uniform(1);
  const double load = std::fabs(from.shear_n) / (from.friction * from.normal_n);
  const auto shear = [&](double share) { return share * from.friction * from.normal_n; };
  switch (move) {
    case Move::load:
      to.shear_n = sign * shear(load + (1 - load) * part);
      break;
    case Move::slide:
      to.shear_n = sign * shear(kSliding);
      break;
    case Move::unload:
      to.shear_n *= part;
      break;
    case Move::reverse:
      to.shear_n = -sign * shear(0.9 * part);
      break;
    case Move::tighten:
      to.normal_n += part * (normal_n.high - from.normal_n);
      break;
    case Move::loosen:
      to.normal_n = std::max(normal_n.low, from.normal_n * (0.5 + 0.45 * part));
      break;
    case Move::together:
      to.normal_n += part * (normal_n.high - from.normal_n);
      to.shear_n += sign * u.uniform(2) * from.friction * (to.normal_n - from.normal_n);
      break;
    case Move::falls:
      to.friction = std::max(friction.low, from.friction * (0.6 + 0.3 * part));
      break;
    case Move::rises:
    case Move::unseen:
      to.friction = std::min(friction.high, from.friction * (1.1 + 0.4 * part));
      if (move == Move::rises)
        to.shear_n += sign * u.uniform(2) * (to.friction * from.normal_n - sign * from.shear_n);
      break;
    case Move::grip:
    case Move::hold:
      break;
  }
  return to;
}

}  // namespace

std::string_view name_of(Move move) noexcept {
  static constexpr std::array<std::string_view, kMoves> kNames{"grip",    "load",    "slide",  "unload",
                                                               "reverse", "tighten", "loosen", "together",
                                                               "falls",   "rises",   "hold",   "unseen"};
  return kNames[static_cast<std::size_t>(move)];
}

Grasp draw_grasp(const slipd::Scene& scene, std::uint64_t seed, std::size_t index, std::size_t moves) {
  Range normal_n = scene.objects.at(0).normal_n, friction = scene.objects.at(0).friction;
  for (const auto& family : scene.objects) {
    normal_n = reach(normal_n, family.normal_n);
    friction = reach(friction, family.friction);
  }
  const RandomStream random = RandomStream(seed ^ 0x6772617370ULL).stream(index);
  Grasp grasp{slipd::draw_contact(scene, seed, index), 2 * std::numbers::pi * random.uniform(0), {}};
  LoadSegment last{Move::grip, grasp.contact.normal_n, 0, grasp.contact.friction, 0};
  const std::size_t segments = moves + 3;
  for (std::size_t i = 0; i < segments; ++i) {
    const RandomStream u = random.stream(i);
    Move move = kDrawn[static_cast<std::size_t>(u.uniform(3) * kDrawn.size())];
    if (i == 0) move = Move::grip;
    if (i == 1) move = Move::load;
    if (i + 1 == segments) move = Move::unseen;
    last = next(move, last, u, normal_n, friction);
    grasp.segments.push_back(last);
    // The tangential force that friction cannot hold is lost to sliding.
    const double most = last.friction * last.normal_n;
    last.shear_n = std::clamp(last.shear_n, -most, most);
  }
  return grasp;
}

}  // namespace lab
