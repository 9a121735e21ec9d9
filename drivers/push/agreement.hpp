// What configuration and hello say together of a writer's frames. Acquire thread; allocates nothing.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "drivers/push/options.hpp"

namespace slipd::push {

// What slipd tells a writer, and people.
using Text = std::array<char, push_layout::kLongestAnswer>;

// What frames are read by.
struct Agreement {
  std::size_t taxels = 0;
  std::uint8_t axes = 3;  // 1 or 3
  // Pa per unit of the frames, along x, y and z.
  std::array<float, 3> scale{1, 1, 1};
  bool zeroed = false;        // frames read 0 without load
  bool calibrated = true;     // values are of a known scale; false: counts or µT
  bool displacement = false;  // values are of Unit::millimetre

  SensorClass sensor_class() const noexcept {
    if (displacement) return SensorClass::displacement;
    if (axes == 1) return SensorClass::normal;
    return taxels == 1 ? SensorClass::wrench : SensorClass::array3;
  }
  bool operator==(const Agreement&) const = default;
};

// What holds while no writer has said anything.
Agreement agreement_without_hello(const Options& options, const SensorSetup& sensor) noexcept;

// Fills `agreed` from a writer's first message. False: it is no hello, or contradicts the configuration; then
// `why` says how, ended by a zero byte.
bool agree(std::span<const std::uint8_t> message, const Options& options, const SensorSetup& sensor,
           Agreement& agreed, Text& why) noexcept;

}  // namespace slipd::push
