// A sensor with all effects: gripper → rubber → rough contact → skin → taxels that lean → noise. It replaces
// the contact model of the ideal sensor, and is driven by the same script. Allocates on construction only.
#pragma once

#include <cstdint>
#include <optional>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "drivers/sim/effects/presets.hpp"
#include "drivers/sim/effects/skin_layer.hpp"
#include "drivers/sim/script.hpp"

namespace slipd::sim {

class RealisticSensor {
 public:
  // `layout` has at least two taxels. The seed decides heights, relief, tilts, shaking and noise.
  RealisticSensor(const EffectSettings& effects, const TaxelLayout& layout, std::uint64_t seed);

  // Longest step of update, ns: a sliding object and the rubber are followed in such steps.
  static constexpr std::int64_t kLongestStepNs = 1'000'000;

  // Goes on to time_ns since the start, at most kLongestStepNs after the last call. `target`: what the
  // gripper and the load are to be then, by the script; its normal force is that of relaxed rubber.
  void update(const LoadTarget& target, std::int64_t time_ns) noexcept;

  // Writes what the taxels sense, with coloured noise and drift. `out`: spans of the layout's size.
  void sense(FrameSlot& out, std::uint64_t number, std::int64_t time_ns) noexcept;
  // Cuts values off at the ends of the measuring range.
  void limit(FrameSlot& out) const noexcept;

  Truth truth() const noexcept { return {contact_.safety_margin(), contact_.friction()}; }
  const RoughContact& contact() const noexcept { return contact_; }

 private:
  double area_m2_;
  StandardLinearSolid rubber_;
  Shaking shaking_;
  RoughContact contact_;
  std::optional<SkinLayer> skin_;
  AxisTilt tilt_;
  ColouredNoise noise_, drift_;
  MeasuringRange range_;
  std::int64_t time_ns_ = 0;
};

}  // namespace slipd::sim
