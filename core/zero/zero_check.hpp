// Whether a stored zero fits what a sensor reads now (docs/methods.md §33). A zero of another sensor, or one
// that is wrong by more than noise and drift explain, must not be subtracted: what is left would look like no
// contact, or like one. Used by BiasEstimator.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/zero/bias.hpp"

namespace slipd {

// Standard deviation of a reading by rounding to the sensor's smallest step: of a value that is even over it.
inline float rounding_noise(float step) noexcept {
  constexpr float kVariance = 1.0F / 12;
  return std::sqrt(kVariance) * step;
}

// Checked by tests/core/zero/zero_check_test.cpp and bias_estimator_test.cpp, on sensors with offsets, noise,
// drift, contacts and exchanges.
struct ZeroCheckOptions {
  // Share of the taxels that have to agree in all channels, 0.1 … 0.5, and at least kBadTaxels. Too small:
  // offsets that happen to be alike pass. Too large: a restart in mid-grasp is without a margin until the
  // object is let go.
  double agree_share = 0.25;
};

// Not thread-safe: the acquire thread's. Allocates in its constructor only.
class ZeroCheck {
 public:
  // What a channel flickers by at least, Pa, and the smallest difference that the sensor tells, Pa; 0: none,
  // or not known.
  struct Floors {
    float noise_normal_pa = 0, noise_shear_pa = 0;
    float step_normal_pa = 0, step_shear_pa = 0;
  };

  // `taxels`: at least 1.
  explicit ZeroCheck(std::size_t taxels, const ZeroCheckOptions& options = {});

  // Whether enough taxels of `reading` (before any zero is subtracted) are, in all channels, where `zero`
  // says that they are without load, or where they were when the sensor was last seen (`last_pa`, as
  // Bias::bias_pa; empty: not known). What is no number does not agree.
  bool agrees(const Frame& reading, const Bias& zero, std::span<const float> last_pa,
              const Floors& floors) const noexcept;

  // Whether `reading` is further below `zero` than any contact presses it, on more taxels than may be bad.
  bool is_below(const Frame& reading, const Bias& zero, const Floors& floors) const noexcept;

  // Keeps the greatest pressure of each taxel; of readings whose zero is in use.
  void note_pressed(std::span<const float> normal_pa, const Bias& zero) noexcept;
  // Forgets it; with a new zero.
  void forget_pressed() noexcept;

  // Mean difference of the normal pressures from the zero, Pa.
  static float mean_off_pa(const Frame& reading, const Bias& zero) noexcept;

 private:
  // kStrongSigmas of a frame, whose noise is no less than that of rounding.
  float tolerance_pa(const Bias& zero, std::size_t channel, const Floors& floors) const noexcept;

  std::size_t taxels_;
  ZeroCheckOptions options_;
  std::vector<float> pressed_pa_;
};

}  // namespace slipd
