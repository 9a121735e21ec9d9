// The contact model at the ends of the world: against 60 digits, along one quantity at a time, the others
// drawn.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/numeric/random.hpp"
#include "tools/sliplab/stability/textbook.hpp"

namespace sliplab {

enum class Axis : std::uint8_t { stiffness, load, margin, force, friction, curvature, size };
inline constexpr Axis kAxes[] = {Axis::stiffness, Axis::load,      Axis::margin, Axis::force,
                                 Axis::friction,  Axis::curvature, Axis::size};

std::string_view name_of(Axis axis) noexcept;  // as in tables: "E2/E1", …

// Places along it: E2/E1 1e-3 … 1e8; 1 - Gamma and Gamma 1e-12 … 0.5; P 1e-9 … 1e3 N; mu 1e-6 … 5; R1/R2 from
// nearly -1 (concave, as tight as the skin) over 0 (flat) to 1000; a/R 1e-6 … 1.
std::vector<double> places_on(Axis axis);

// A contact of the paper's at this place of the axis, its other quantities drawn; s anywhere, often near the
// rim or the stick zone's edge.
Case draw_case(Axis axis, double place, const slipd::RandomStream& random);

// Largest relative errors over a's, p0's, c's, Q's, p's, q's and alpha's.
struct Worst {
  Axis axis;
  double place;
  double closed_form;   // slipd's forms
  double history;       // q as a sum of disc terms, of the contact's largest q: what simulated sensors feel
  double single_angle;  // alpha in single precision, as the estimators take it from p and q
  double textbook_double;  // the textbook's forms
  double textbook_single;
};
Worst worst_at(Axis axis, double place, std::size_t cases, std::uint64_t seed);

}  // namespace sliplab
