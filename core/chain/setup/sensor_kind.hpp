// What kind of sensor a set-up describes. Chosen once; a pipeline for each kind does the rest (pipeline.hpp).
#pragma once

#include <cstdint>
#include <string_view>

#include "core/chain/setup/setup.hpp"

namespace slipd {

enum class SensorKind : std::uint8_t {
  pressure_only,  // measures no shear: contact and faults, never a margin
  one_force,      // one force vector, with or without its torque: friction over time gives the margin
  pillars,        // tips of pillars, each on its own: what each carries shows friction
  flat_pad,       // several taxels on a flat skin: sums over them, as one force; sliding by their pattern
  few_taxels,     // a curved skin of at most kFewTaxels taxels: fit reads all of them, and friction over time
  array,          // a curved skin of more taxels: a frame shows its margin by itself
  displacement    // measures no force: contact, and slides by the field of displacement; never a margin
};

std::string_view to_string(SensorKind kind) noexcept;  // "pressure_only", …

SensorKind kind_of(const ChainSetup& setup) noexcept;

// Whether no single frame of this kind determines its margin.
constexpr bool needs_history(SensorKind kind) noexcept {
  return kind != SensorKind::array;
}

// Whether its frames are read by a contact model.
constexpr bool has_contact_model(SensorKind kind) noexcept {
  return kind == SensorKind::few_taxels || kind == SensorKind::array;
}

// Depth of the taxels under the skin as it counts, m; 0: at the surface. A skin that is thinner than a ninth
// of a taxel's side counts as none: a taxel's average under it would take hundreds of points, and is within
// some per cent what it is at the surface. Margins by forces alone need no contact model, so that a skin has
// no effect on them.
double sensed_depth_m(const ChainSetup& setup) noexcept;

}  // namespace slipd
