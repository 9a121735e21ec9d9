// The angle alpha between tangential and normal traction on each taxel (docs/theory.md §3.3): what the
// model is trained on and what an estimator projects. Both go through here, so that both see the same. Any
// thread.
#pragma once

#include <cstddef>
#include <span>

namespace slipd {

// Where the angle is taken: only where the pressure says that there is contact. Outside it would be
// atan(noise/noise).
struct AlphaMask {
  float least_pa = 0;  // taxels at or below have angle 0, and so have those that are not a number
  float along_x =
      1;  // unit vector of the shear resultant; shear is taken along it with its sign, so that noise
  float along_y = 0;  // does not add up to a load that is not there
};

// alpha[i] = atan((shear_x[i] along_x + shear_y[i] along_y) / normal[i]) in (-pi/2, pi/2) where normal[i] >
// least_pa, else 0. All spans of one size; least_pa >= 0. Error at most 1e-6 rad (polynomial of
// docs/methods.md §35: 2e-8, and float rounding). Vectorised for the processor it runs on.
void alpha_of(std::span<const float> normal_pa, std::span<const float> shear_x_pa,
              std::span<const float> shear_y_pa, const AlphaMask& mask, std::span<float> alpha) noexcept;

// alpha[i] = atan(ratio[i]) for ratio >= 0, to the same accuracy.
void alpha_of_ratio(std::span<const float> ratio, std::span<float> alpha) noexcept;

// Share of the frame's greatest pressure above which a taxel is taken, for noise of a half-width that is
// `noise` times that maximum. A Hertzian contact is at a tenth of its peak pressure at 0.995 of its radius:
// nothing is lost by it.
constexpr float mask_fraction(double noise) noexcept {
  return static_cast<float>(noise > 0.1 / 1.5 ? 1.5 * noise : 0.1);
}

}  // namespace slipd
