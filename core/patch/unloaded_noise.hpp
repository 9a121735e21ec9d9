// How much a sensor's readings flicker and wander about its zero while nothing touches it, measured over
// time. A single frame of a real sensor does not show it: taxels that are hooked or pulled, and cross-talk
// between taxels, make negative pressure that is no noise. Estimate thread; fixed memory, nothing allocates.
#pragma once

#include <cstdint>
#include <optional>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"

namespace slipd {

// Root mean squares about the zero: flicker, vibration, drift and the zero's own error.
struct SensorNoise {
  // Of one taxel, over all taxels: pressure, and one component of shear; Pa, > 0 and >= 0.
  double normal_pa = 0;
  double shear_pa = 0;
  // Of the sums over all taxels: P, and one component of Q; N, >= 0. More than the taxels' noise explains
  // where taxels share it.
  double normal_n = 0;
  double shear_n = 0;
};

// Time in which a sensor's noise and zero change, as it warms up: what is older is forgotten to 1/e; s, 1 …
// 1000. Too small: chance is noise, and a slow touch moves the zero. Too large: a sensor that warms up is
// left behind.
inline constexpr double kDrift_s = 10;

// The zero of shear drifts further than that of pressure: the largest |Q| that counts as no load, over the
// largest such P; 1 … 10. Too small: drift and jitter of the zero are a pull. Too large: a contact that is
// pulled at without pressure goes unnoticed.
inline constexpr double kShearOverNormal = 3;

// Checked with `slipd-bench`.
struct UnloadedNoiseOptions {
  // Blocks before the noise is known; 1 … 50. Too small: chance. Too large: the first grasp comes before it.
  int min_blocks = 2;
};

class UnloadedNoise {
 public:
  // unloaded_n: |P| of a block's mean up to which nothing touches the sensor, N, > 0; |Q| up to
  // kShearOverNormal times as much. Single frames of a noisy sensor exceed it.
  UnloadedNoise(const TaxelLayout& layout, double unloaded_n, const UnloadedNoiseOptions& options = {});

  // Every frame with a zero, in order of time.
  void update(const Frame& frame) noexcept;

  // None until the sensor was unloaded for long enough, and for one whose pressure does not flicker at all,
  // which says nothing of its noise under load.
  const std::optional<SensorNoise>& now() const noexcept { return noise_; }

 private:
  // Mean squares, and means of the sums.
  struct Means {
    double normal_pa2 = 0, shear_pa2 = 0, normal_n2 = 0, shear_n2 = 0;
    double normal_n = 0, shear_x_n = 0, shear_y_n = 0;
    void move(const Means& to, double gain) noexcept;
  };
  Means means_of(const Frame& frame) const noexcept;
  void finish_block() noexcept;
  void count(const Means& block) noexcept;

  double area_m2_;
  double unloaded_n_;
  UnloadedNoiseOptions options_;
  Means block_, waiting_, mean_;  // of the block under way, of the one before it, of all before
  std::int64_t began_ns_ = 0;
  int frames_ = 0;  // of the block under way
  bool has_waiting_ = false;
  int blocks_ = 0;  // counted so far
  std::optional<SensorNoise> noise_;
};

}  // namespace slipd
