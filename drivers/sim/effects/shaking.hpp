// The gripper's own shaking: motors, an arm that moves. A few sinusoids of random frequency and phase within
// a band; a pure function of time.
#pragma once

#include <array>
#include <cstdint>

namespace slipd::sim {

struct ShakingSettings {
  // Root mean square of the change of each force, a share of the normal force; 0 … 0.1.
  double share = 0;
  // The band, Hz; 0 < lowest <= highest.
  double lowest_hz = 5;
  double highest_hz = 40;
};

class Shaking {
 public:
  Shaking(const ShakingSettings& settings, std::uint64_t seed) noexcept;

  // Relative change of the normal force, and tangential force over normal force, at a time in s.
  double normal(double time_s) const noexcept { return value(0, time_s); }
  double shear(double time_s) const noexcept { return value(1, time_s); }

 private:
  static constexpr std::size_t kWaves = 6;
  struct Wave {
    double hz = 0, phase_rad = 0;
  };
  double value(std::size_t direction, double time_s) const noexcept;

  double share_;
  std::array<std::array<Wave, kWaves>, 2> waves_;
};

}  // namespace slipd::sim
