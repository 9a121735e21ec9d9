// What slipd says of random grasps whose sensor breaks in mid-grasp: whether the fault is reported, after how
// long, and how many margins are too safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lab/collect.hpp"
#include "lab/estimator.hpp"
#include "lab/faults/fault.hpp"
#include "lab/frames/preset_grasp.hpp"
#include "lab/frames/random_frames.hpp"
#include "lab/tally/tally.hpp"

namespace lab {

struct FaultLine {
  slipd::sim::Preset preset = slipd::sim::Preset::ideal;  // which kind of sensor breaks
  std::size_t columns = 0;                                // taxels along each side of the pad
  std::string method;
  Fault fault = Fault::none;
  std::size_t grasps = 0;
  // Grasps whose fault was reported: an estimate with another health than good, or without the margin that
  // the healthy sensor's estimator gave at that frame.
  std::size_t reported = 0;
  // Of these, with another health than good.
  std::size_t named = 0;
  // The health that most of these have first, good if there are none.
  slipd::Health as = slipd::Health::good;
  // Grasps whose fault was not reported, and changed no margin that was given by more than kNoEffect.
  std::size_t without_effect = 0;
  // Frames from the fault's first to the first that reported it: the middle one and the latest; -1: none
  // reported.
  long median_frames = -1;
  long last_frames = -1;
  // Frames with the fault, later than kGraceFrames after it began, in state ok.
  std::uint64_t answered = 0;
  // Of these, with a margin more than kGrossError above the truth where the healthy sensor's is not.
  std::uint64_t too_safe = 0;
  // Of the same frames of the healthy sensor, those in state ok, and the margins too safe among them.
  std::uint64_t sound_answered = 0;
  std::uint64_t sound_too_safe = 0;
  // Frames of the healthy sensor with another health than good, the grasps that have any, the health that
  // most of the frames have (good if there are none), and all its frames.
  std::uint64_t false_alarms = 0;
  std::size_t grasps_with_false_alarms = 0;
  slipd::Health false_as = slipd::Health::good;
  std::uint64_t sound_frames = 0;
};

// Frames after a fault's begin in which a margin may still be wrong.
inline constexpr std::uint64_t kGraceFrames = 5;

// Margin of the fault's estimator less that of the healthy sensor's, up to which a fault had no effect.
inline constexpr double kNoEffect = 0.1;

struct FaultSetup {
  std::size_t grasps = 20;  // of each line
  Sampling sensing;
  std::uint64_t seed = 1;
  unsigned threads = 2;
};

// Every fault of `faults` on the same grasps.
std::vector<FaultLine> measure_faults(const Estimator& estimator, const std::vector<Fault>& faults,
                                      const FaultSetup& setup, const Done& done = {});

// The same of grasps of a simulated preset: `chain` is of the bench, each other grasp slides.
// FaultSetup::sensing has no part in it.
std::vector<FaultLine> measure_faults(const PresetBench& bench, const slipd::ChainSetup& chain,
                                      const std::vector<Fault>& faults, const FaultSetup& setup,
                                      const Done& done = {});

}  // namespace lab
