// How often the truth lies within an answer's sigma, over whole grasps: those that the driver `sim` plays by
// default, and random ones (histories/grasp.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "core/chain/chain.hpp"
#include "paper/model/model.hpp"

namespace lab {

// The error of a margin above the truth that counts as too safe at low rates.
inline constexpr double kTooSafe = 0.1;

// Frames in contact.
class CoverageTally {
 public:
  // `traced`: false while friction has changed and no frame has shown it; such answers are counted apart.
  void add(const slipd::Estimate& estimate, double truth, bool traced);
  void add(const CoverageTally& other);

  double frames() const noexcept { return frames_; }
  double answered() const noexcept { return frames_ > 0 ? (ok_ + untraced_) / frames_ : slipd::kUnknown; }
  double untraced() const noexcept { return untraced_; }  // answers without a trace of a change
  // The following are of the answers that are not counted apart; NaN where there is none.
  double answers() const noexcept { return ok_; }
  double mean_error() const noexcept { return share(error_); }
  double within_two_sigma() const noexcept { return share(within_two_); }
  double within_three_sigma() const noexcept { return share(within_three_); }
  double beyond_three_sigma() const noexcept { return ok_ - within_three_; }
  double too_safe() const noexcept { return too_safe_; }  // answers more than kTooSafe above the truth
  double worst() const noexcept { return worst_; }        // largest error
  double least_sigma() const noexcept { return least_sigma_; }

 private:
  double share(double of) const noexcept { return ok_ > 0 ? of / ok_ : slipd::kUnknown; }

  double frames_ = 0, ok_ = 0, untraced_ = 0, error_ = 0, within_two_ = 0, within_three_ = 0, too_safe_ = 0,
         worst_ = 0;
  double least_sigma_ = 1;
};

struct Coverage {
  CoverageTally all;
  std::map<std::string, CoverageTally> by_phase;  // what the gripper does
  void add(const std::string& phase, const slipd::Estimate& estimate, double truth, bool traced);
  void add(const Coverage& other);
};

struct CoverageSample {
  std::size_t grasp;
  double time_s;
  const std::string& phase;
  double normal_n, shear_n;
  slipd::Truth truth;
  bool traced;
  slipd::Estimate estimate;
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
Coverage measure_cycle(const slipd::ChainSetup& chain, const std::shared_ptr<const slipd::Model>& model,
                       const CoverageSetup& setup, const std::function<void(double)>& done = {});

// Random grasps of the chain's scene.
Coverage measure_histories(const slipd::ChainSetup& chain, const std::shared_ptr<const slipd::Model>& model,
                           const CoverageSetup& setup, const std::function<void(double)>& done = {});

}  // namespace lab
