#include "daemon/rpc/methods/frame_bytes.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {
namespace {

constexpr float kPressureSteps = 255, kShearSteps = 127;

float peak_of(std::span<const float> values) {
  float peak = 0;
  for (const float value : values) {
    if (std::isfinite(value)) peak = std::max(peak, std::abs(value));
  }
  return peak;
}

// A peak so small that the scale overflows is none.
void append_steps(std::string& out, std::span<const float> values, float peak, float steps, float low) {
  const float scale = peak > 0 && std::isfinite(steps / peak) ? steps / peak : 0;
  constexpr float kHalf = 0.5F;
  for (const float value : values) {
    const float step = std::isfinite(value) ? std::clamp(scale * value, low, steps) : 0;
    out += static_cast<char>(static_cast<int>(step < 0 ? step - kHalf : step + kHalf));
  }
}

}  // namespace

FrameBytes frame_bytes(std::span<const float> normal_pa, std::span<const float> shear_x_pa,
                       std::span<const float> shear_y_pa) {
  FrameBytes bytes{peak_of(normal_pa), std::max(peak_of(shear_x_pa), peak_of(shear_y_pa)), {}};
  bytes.values.reserve(normal_pa.size() + shear_x_pa.size() + shear_y_pa.size());
  append_steps(bytes.values, normal_pa, bytes.peak_pa, kPressureSteps, 0);
  append_steps(bytes.values, shear_x_pa, bytes.peak_shear_pa, kShearSteps, -kShearSteps);
  append_steps(bytes.values, shear_y_pa, bytes.peak_shear_pa, kShearSteps, -kShearSteps);
  return bytes;
}

}  // namespace slipd
