// Random grasps of a simulated sensor with one preset: holds and slips.
#pragma once

#include <cstdint>
#include <optional>

#include "core/chain/chain.hpp"
#include "drivers/sim/simulated_sensor.hpp"

namespace lab {

enum class GraspKind : std::uint8_t {
  hold,  // gripped, loaded to at most 0.4 of what holds, in half of them gripped harder and loaded anew
  slip   // gripped, held, loaded until it slides, and 0.5 s longer
};

// A sensor that a preset is made for.
struct PresetBench {
  slipd::sim::Preset preset;
  slipd::TaxelLayout layout;
  slipd::Skin skin;
  double rate_hz;
};
PresetBench bench_of(slipd::sim::Preset preset);

// The chain of a scene with friction from 0.3 to 1. `friction`: known beforehand; none: it is not.
slipd::ChainSetup chain_of(const PresetBench& bench, std::optional<double> friction);

// The grasp `index` of its kind: normal force 2–8 N, friction 0.3–1, closing in 50–150 ms, held for 0.5–1.5
// s, loaded in 50 ms–2 s.
slipd::sim::SensorSettings draw_preset_grasp(const PresetBench& bench, GraspKind kind, std::uint64_t seed,
                                             std::size_t index);

}  // namespace lab
