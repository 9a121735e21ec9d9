// How often the truth lies within an answer's sigma, over whole grasps: those that the driver `sim` plays by
// default, and random ones (frames/random_grasp.hpp).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "lab/collect.hpp"
#include "lab/estimator.hpp"
#include "lab/grasp/drive.hpp"
#include "lab/tally/tally.hpp"

namespace lab {

// The error of a margin above the truth that counts as too safe at low rates.
inline constexpr double kTooSafe = 0.1;

// Frames in contact. Answers given while friction has changed and no frame has shown it are counted apart:
// nothing can be right about them.
struct CoverageTally {
  Tally traced{kTooSafe}, untraced{kTooSafe};

  void add(const slipd::Estimate& estimate, const slipd::Truth& truth, bool shown) {
    (shown ? traced : untraced).add(estimate, truth);
  }
  void add(const CoverageTally& other) {
    traced.add(other.traced);
    untraced.add(other.untraced);
  }
  double frames() const noexcept { return traced.frames() + untraced.frames(); }
  double answered() const noexcept { return (traced.answers() + untraced.answers()) / frames(); }
  double least_sigma() const noexcept { return std::min(traced.least_sigma(), untraced.least_sigma()); }
};

struct Coverage {
  CoverageTally all;
  std::map<std::string, CoverageTally> by_phase;  // what the gripper does
  void add(const std::string& phase, const slipd::Estimate& estimate, const slipd::Truth& truth, bool traced);
  void add(const Coverage& other);
};

struct CoverageSample {
  std::size_t grasp;
  const std::string& phase;
  const GraspSample& sample;
};

struct CoverageSetup {
  std::size_t grasps = 8;  // of each line: whole cycles, or random grasps
  double rate_hz = 1000;   // frames a second
  double noise =
      0.01;  // of random grasps, half-width, a fraction of the frame's largest pressure (sensor noise)
  std::uint64_t seed = 1;
  unsigned threads = 2;
  std::function<void(const CoverageSample&)>
      watch;  // empty, or called for each frame; then with one thread only
};

// The cycle that `sim` plays by default, with its noise. The first contact lies in the pad's middle as there,
// the others up to 1 mm off it.
Coverage measure_cycle(const Estimator& estimator, const CoverageSetup& setup, const Done& done = {});

// Contacts of the chain's scene that are loaded to 0.2 … 0.7 of what friction holds, and held for 20 s.
Coverage measure_holds(const Estimator& estimator, const CoverageSetup& setup, const Done& done = {});

// Random grasps of the chain's scene.
Coverage measure_histories(const Estimator& estimator, const CoverageSetup& setup, const Done& done = {});

}  // namespace lab
