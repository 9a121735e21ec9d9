// The usual behaviour of a sensor, as a baseline for finding its faults: numbers that all checks of that kind
// share. Checked with `slipd-lab faults` and on recordings of real sensors.
#pragma once

#include <algorithm>
#include <cstdint>

namespace slipd {

// Frames over which what is usual is averaged; frames, 32 … 1000. Too small: chance, and the beginning of a
// quick motion, are called faults. Too large: nothing is said of short contacts.
inline constexpr std::uint32_t kMemoryFrames = 64;

// Frames before something is said of the next one.
inline std::uint32_t learning_frames() noexcept {
  return kMemoryFrames / 2;
}

// What exceeds the most of late by this factor is not usual; 1.5 … 10. Too small: quick grips, vibrations and
// slides over few taxels are called faults. Too large: offsets, spikes and another contact's frames are
// believed.
inline constexpr double kBeyondUsual = 3;

// What is off by this factor no contact explains: pressures for a contact's size, and the mean squared change
// of one channel while the others are as usual; 5 … 100. Too small: quick grips of flat skins, contacts
// unlike a sphere, vibrations and quick loads are called faults. Too large: a wrong unit, and noise, are
// believed.
inline constexpr double kWrongScale = 30;

// Share of changes that turn, from which they are noise and no load; 0.1 … 0.6. Independent noise turns in 2
// of 3 frames, a load without noise hardly ever. Too small: a trembling load passes for noise. Too large:
// noise under a fast load is not seen, and a frozen sensor is believed.
inline constexpr double kNoiseTurns = 0.25;

// Frames in a row that show a fault which one frame does not show, or its end; frames, 2 … 20. Too small: a
// frame that a driver has twice takes the margin away, and a loose contact makes the state flicker. Too
// large: a margin is given from the past.
inline constexpr std::uint32_t kSureFrames = 3;

// Mean of a quantity that is small while a contact goes on, and the largest of late.
struct UsualValue {
  double mean = 0;
  double peak = 0;
  std::uint32_t frames = 0;  // that it is of, at most kMemoryFrames

  bool known() const noexcept { return frames >= learning_frames(); }
  void learn(double value) noexcept {
    frames = std::min<std::uint32_t>(frames + 1, kMemoryFrames);
    mean += (value - mean) / frames;
    peak = std::max(value, peak * (1 - 1.0 / kMemoryFrames));
  }
};

}  // namespace slipd
