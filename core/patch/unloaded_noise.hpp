// How much a sensor's readings flicker and wander about its zero while nothing touches it, measured over time.
// A single frame of a real sensor does not show it: taxels that are hooked or pulled, and cross-talk between
// taxels, make negative pressure that is no noise. Estimate thread; fixed memory, nothing allocates.
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

// Checked with `tools/real`.
struct UnloadedNoiseOptions {
  // Frames are counted in blocks of this time, s, 0.02 … 1, and a block only if the next one is unloaded too.
  // Too small: an approaching contact counts as noise. Too large: short pauses between grasps are not used.
  double block_s = 0.1;
  // Time in which older blocks are forgotten to 1/e, s, 1 … 100. Too small: chance. Too large: a sensor that
  // warms up is taken for a quiet one.
  double follow_s = 5;
  // Blocks before the noise is known; 1 … 50. Too small: chance. Too large: the first grasp comes before it.
  int min_blocks = 2;
};

class UnloadedNoise {
 public:
  explicit UnloadedNoise(const TaxelLayout& layout, const UnloadedNoiseOptions& options = {});

  // Every frame with a zero, in order of time. `unloaded`: nothing touches the sensor.
  void update(const Frame& frame, bool unloaded) noexcept;

  // None until the sensor was unloaded for long enough, and for one whose pressure does not flicker at all,
  // which says nothing of its noise under load.
  const std::optional<SensorNoise>& now() const noexcept { return noise_; }

 private:
  // Mean squares.
  struct Squares {
    double normal_pa2 = 0, shear_pa2 = 0, normal_n2 = 0, shear_n2 = 0;
    void move(const Squares& to, double gain) noexcept;
  };
  Squares squares_of(const Frame& frame) const noexcept;
  void count(const Squares& block) noexcept;

  double area_m2_;
  UnloadedNoiseOptions options_;
  Squares block_, waiting_, mean_;  // of the block under way, of the one before it, of all before
  std::int64_t began_ns_ = 0;
  int frames_ = 0;  // of the block under way
  bool has_waiting_ = false;
  int blocks_ = 0;  // counted so far
  std::optional<SensorNoise> noise_;
};

}  // namespace slipd
