#include "drivers/sim/effects/presets.hpp"

#include <array>

namespace slipd::sim {
namespace {

constexpr std::array kPresets{Preset::ideal, Preset::pillars, Preset::magnetic_skin};

// Finger tips of 3 x 3 pillars at a pitch of 7 mm. "Measured": median of 17 recordings of grasps that nobody
// pulled at (`lab/slipd-bench/effects`); the others are of the right order and not measured.
EffectSettings pillars() noexcept {
  EffectSettings effects;
  effects.grip = {.stiffening = 5, .relaxation_s = 0.09};  // measured: overshoot 3.5, closing in 87 ms
  effects.shaking = {.share = 0.002, .lowest_hz = 10, .highest_hz = 60};  // measured: 0.2 % of P
  effects.contact.thickness_m = 0.004;
  effects.contact.tangential = 0.4;
  effects.contact.height_sigma_m = 40e-6;
  effects.contact.texture = {.rms_m = 20e-6, .shortest_m = 0.006, .longest_m = 0.03};
  effects.contact.one_side_friction = 0.8;
  effects.tilt = {.base_radius_m = 0.05, .spread_rad = 0.03};  // measured: sum |q| = 0.15 P at rest
  effects.noise = {.sigma_pa = 92, .correlation_s = 0.055, .common = 0.1};  // measured: 4.5 mN, 55 ms, 0.07
  effects.drift = {.sigma_pa = 100, .correlation_s = 60, .common = 0.5, .from_zero = true};
  effects.range = {.normal_pa = 400e3, .shear_pa = 160e3};
  return effects;
}

// 4 x 4 magnets at a pitch of 4.7 mm. "Measured": on six recordings of two fingers, at 2 Pa a count.
EffectSettings magnetic_skin() noexcept {
  EffectSettings effects;
  effects.grip = {.stiffening = 2, .relaxation_s = 0.2};
  effects.shaking = {.share = 0.005, .lowest_hz = 3, .highest_hz = 20};
  effects.contact.thickness_m = 0.004;
  effects.contact.tangential = 0.5;
  effects.contact.texture = {.rms_m = 30e-6, .shortest_m = 0.006, .longest_m = 0.03};
  effects.contact.one_side_friction = 0.8;
  effects.depth_m = 0.0025;
  effects.tilt = {.spread_rad = 0.03};
  effects.noise = {
      .sigma_pa = 16, .correlation_s = 0.015, .common = 0.1};  // measured: 8 counts, 0.3 a row, 0.1
  effects.drift = {.sigma_pa = 50, .correlation_s = 60, .common = 0.5, .from_zero = true};
  effects.range = {.normal_pa = 56e3, .shear_pa = 65e3};  // what is left of 16 bits above the zero
  return effects;
}

}  // namespace

std::string_view to_string(Preset preset) noexcept {
  static constexpr std::string_view kNames[] = {"ideal", "pillars", "magnetic-skin"};
  return kNames[static_cast<std::size_t>(preset)];
}

std::optional<Preset> preset_of(std::string_view name) noexcept {
  for (const Preset preset : kPresets) {
    if (to_string(preset) == name) return preset;
  }
  return std::nullopt;
}

std::optional<EffectSettings> effects_of(Preset preset) noexcept {
  switch (preset) {
    case Preset::pillars:
      return pillars();
    case Preset::magnetic_skin:
      return magnetic_skin();
    case Preset::ideal:
      break;
  }
  return std::nullopt;
}

}  // namespace slipd::sim
