// What a sensor's taxels are multiplied by, from somebody's calibration.
#pragma once

#include <span>

#include "core/frame/frame.hpp"

namespace slipd {

// Acquire thread; allocates nothing. All channels of each taxel by its gain, of which there is one for each.
inline void apply_gain(std::span<const float> gain, FrameSlot& frame) noexcept {
  const float* const by = gain.data();
  for (const auto& channel : {frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa}) {
    float* const values = channel.data();
    for (std::size_t i = 0; i < gain.size(); ++i) values[i] *= by[i];
  }
}

}  // namespace slipd
