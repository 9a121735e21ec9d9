// Noise that is correlated in time and between taxels: a first-order autoregressive process of each channel
// of each taxel (Ornstein and Uhlenbeck 1930), and one that all taxels of a channel share. With a long
// correlation time it is drift. Drawn from hashes of the frame's number: the same frames give the same noise.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/numeric/random.hpp"

namespace slipd::sim {

struct ColouredNoiseSettings {
  // Standard deviation of a channel, Pa; 0: none.
  double sigma_pa = 0;
  // Time in which the correlation falls to 1/e, s; above 0.
  double correlation_s = 0.02;
  // Correlation of two taxels, 0 … 1.
  double common = 0;
  // It begins at 0 and grows to its size, as the drift of a sensor that was zeroed when it was switched on.
  bool from_zero = false;
};

class ColouredNoise {
 public:
  ColouredNoise(const ColouredNoiseSettings& settings, std::size_t taxels, std::uint64_t seed);

  // Adds the noise of frame `number` at `time_s`; both rise from call to call. `channels`: three spans of the
  // taxels each.
  void add(std::span<const std::span<float>> channels, std::uint64_t number, double time_s) noexcept;

 private:
  // Standard deviation 1, mean 0: the sum of three uniform numbers.
  static float draw(const RandomStream& draws, std::uint64_t i) noexcept;

  ColouredNoiseSettings settings_;
  RandomStream draws_;
  std::vector<float> own_;  // of each taxel, then the common one; channel after channel; standard deviation 1
  std::size_t taxels_;
  double last_s_ = 0;
  bool begun_ = false;
};

}  // namespace slipd::sim
