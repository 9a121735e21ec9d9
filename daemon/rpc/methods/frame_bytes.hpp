// A frame with a byte for each value, for pictures: a quarter of what float32 takes. Any thread.
#pragma once

#include <span>
#include <string>

namespace slipd {

struct FrameBytes {
  // The largest finite magnitude of the pressures, Pa; at least 0.
  float peak_pa = 0;
  // The same of both shears, Pa.
  float peak_shear_pa = 0;
  // Of each taxel the pressure in 255ths of peak_pa (uint8; below 0 is 0), then of each shear x, then shear
  // y, in 127ths of peak_shear_pa (int8). What is not finite is 0.
  std::string values;
};

// The spans have the same size. Throws std::bad_alloc.
FrameBytes frame_bytes(std::span<const float> normal_pa, std::span<const float> shear_x_pa,
                       std::span<const float> shear_y_pa);

}  // namespace slipd
