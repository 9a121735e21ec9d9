// The accuracy of the contact model at extreme parameters, against arithmetic of 60 digits: along one
// quantity at a time, the others drawn at random.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/numeric/random.hpp"
#include "lab/stability/textbook.hpp"

namespace lab {

enum class Axis : std::uint8_t { stiffness, load, margin, force, friction, curvature, size };
inline constexpr Axis kAxes[] = {Axis::stiffness, Axis::load,      Axis::margin, Axis::force,
                                 Axis::friction,  Axis::curvature, Axis::size};

std::string_view name_of(Axis axis) noexcept;  // as in tables: "E2/E1", …

// Values along an axis: E2/E1 1e-3 … 1e8; 1 - Gamma and Gamma 1e-12 … 0.5; P 1e-9 … 1e3 N; mu 1e-6 … 5; R1/R2
// from nearly -1 (concave, conforming to the skin) over 0 (flat) to 1000; a/R 1e-6 … 1.
std::vector<double> places_on(Axis axis);

// A contact of the paper's family with this value on the axis, its other quantities drawn; s is drawn, often
// near the rim or the edge of the stick zone.
Case draw_case(Axis axis, double place, const slipd::RandomStream& random);

// Largest relative error of a, p0, c, Q, p, q and alpha.
struct ContactModelError {
  Axis axis;
  double place;
  double closed_form;   // slipd's closed forms
  double history;       // q as the sum of disc terms that simulated sensors use, of the contact's largest q
  double single_angle;  // alpha in single precision from p and q, as the estimators compute it
  double textbook_double;  // the textbook's formulas in double precision
  double textbook_single;  // the textbook's formulas in single precision
};
ContactModelError model_error_at(Axis axis, double place, std::size_t cases, std::uint64_t seed);

}  // namespace lab
