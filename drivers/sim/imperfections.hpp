// The imperfections of a real sensor: noise, unequal gains, zero offsets, drift, dead taxels, late and lost
// frames. Each is a hash of the seed, the frame's number and the taxel. So frames are the same on any machine
// and do not depend on the frames before.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/numeric/random.hpp"

namespace slipd::sim {

enum class NoiseKind : std::uint8_t {
  sensor,   // half-width: a fraction of full scale, on all three channels, also without contact
  relative  // half-width: a fraction of the frame's largest pressure on pressure, of its largest shear on
            // shear
};

struct ImperfectionSettings {
  std::uint64_t seed = 1;                    // the same seed gives the same frames
  double noise = 0;                          // half-width of uniform noise, share of what noise_kind names
  NoiseKind noise_kind = NoiseKind::sensor;  // what the noise is a fraction of
  double full_scale_pa = 1e5;                // of noise_kind sensor, Pa
  double drop = 0;                           // share of frames that are lost, 0 … 1
  double late_ms = 0;                        // delays are uniform from 0 to this, ms
  double dead = 0;                           // share of taxels that always read 0, 0 … 1
  double gain_spread = 0;                    // gains are uniform within 1 ± this
  double zero_spread_pa = 0;  // zero offsets of each channel of each taxel are uniform within ± this, Pa
  double drift_pa_s = 0;      // drift rates of these offsets are uniform within ± this, Pa/s
};

class Imperfections {
 public:
  Imperfections(const ImperfectionSettings& settings, std::size_t taxels);

  // Acquire thread; allocates nothing. Turns the true values in `frame` into the sensor's. `number`: of the
  // frame, from 0. `elapsed_s`: since the sensor was switched on.
  void apply(FrameSlot& frame, std::uint64_t number, double elapsed_s) const noexcept;

  bool lost(std::uint64_t number) const noexcept;
  std::int64_t late_ns(std::uint64_t number) const noexcept;
  std::span<const std::uint32_t> dead() const noexcept { return dead_; }

 private:
  void add_noise(FrameSlot& frame, std::uint64_t number) const noexcept;

  ImperfectionSettings settings_;
  RandomStream noise_, loss_, delay_;
  std::vector<float> gain_;          // of each taxel; empty: all 1
  std::vector<float> zero_pa_;       // normal of all taxels, then shear x, then shear y; empty: none
  std::vector<float> drift_pa_s_;    // in the same order; empty: none
  std::vector<std::uint32_t> dead_;  // indices of dead taxels
};

}  // namespace slipd::sim
