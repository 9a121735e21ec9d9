// What makes a simulated sensor unlike the contact model: all effects together, and the presets that a
// configuration chooses from (option `preset`, docs/simulation.md).
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "drivers/sim/effects/axis_tilt.hpp"
#include "drivers/sim/effects/coloured_noise.hpp"
#include "drivers/sim/effects/rough_contact.hpp"
#include "drivers/sim/effects/shaking.hpp"
#include "drivers/sim/effects/standard_linear_solid.hpp"

namespace slipd::sim {

enum class Preset : std::uint8_t {
  ideal,          // the contact model itself: a Hertz contact with its load history
  pillars,        // pillars of rubber, each a contact of its own
  magnetic_skin,  // magnets under a layer of rubber
};

std::string_view to_string(Preset) noexcept;                 // "ideal", "pillars", "magnetic-skin"
std::optional<Preset> preset_of(std::string_view) noexcept;  // by that name

// Values beyond are cut off, Pa; infinity: no limit.
struct MeasuringRange {
  double normal_pa = std::numeric_limits<double>::infinity();
  double shear_pa = std::numeric_limits<double>::infinity();
};

struct EffectSettings {
  GripSettings grip;
  ShakingSettings shaking;
  RoughContactSettings contact;
  // Depth of the taxels under the rubber, m; 0: each taxel is an element of the contact.
  double depth_m = 0;
  TiltSettings tilt;
  ColouredNoiseSettings noise;
  ColouredNoiseSettings drift;
  MeasuringRange range;
};

// The effects of a preset; none for `ideal`. Young's modulus, curvature and apex of its contact are left at
// their defaults: the sensor's skin and the object have them.
std::optional<EffectSettings> effects_of(Preset preset) noexcept;

}  // namespace slipd::sim
