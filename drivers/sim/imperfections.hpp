// What lies between a contact and the numbers of a real sensor: noise, taxels that differ, drift, dead
// taxels, frames that come late or never. Everything is a hash of the seed, the frame's number and the taxel:
// the same on any machine, and whatever else was read before.
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
  std::uint64_t seed = 1;
  double noise = 0;  // uniform, half-width as a fraction of 1
  NoiseKind noise_kind = NoiseKind::sensor;
  double full_scale_pa = 1e5;
  double drop = 0;            // share of frames that never come
  double late_ms = 0;         // frames come up to this late, uniformly
  double dead = 0;            // share of taxels that always read 0
  double gain_spread = 0;     // gains lie uniformly within 1 ± this
  double zero_spread_pa = 0;  // zeros lie off 0, each channel of each taxel by its own within ± this
  double drift_pa_s = 0;  // zeros run away, each channel of each taxel at a rate of its own within ± this
};

class Imperfections {
 public:
  Imperfections(const ImperfectionSettings& settings, std::size_t taxels);

  // Acquire thread, allocation-free. `frame` holds what the contact is; afterwards what the sensor says.
  // `number`: of the frame, from 0; elapsed_s: since the sensor was switched on.
  void apply(FrameSlot& frame, std::uint64_t number, double elapsed_s) const noexcept;

  bool lost(std::uint64_t number) const noexcept;
  std::int64_t late_ns(std::uint64_t number) const noexcept;
  std::span<const std::uint32_t> dead() const noexcept { return dead_; }

 private:
  void add_noise(FrameSlot& frame, std::uint64_t number) const noexcept;

  ImperfectionSettings settings_;
  RandomStream noise_, loss_, delay_;
  std::vector<float> gain_;          // empty: all 1
  std::vector<float> zero_pa_;       // as drift_pa_s_
  std::vector<float> drift_pa_s_;    // normal, shear x, shear y of all taxels; empty: none
  std::vector<std::uint32_t> dead_;  // taxels
};

}  // namespace slipd::sim
