// The path of force and torque over a grasp: whether their load is at its maximum, came there in a straight
// line, and leaves no trace of earlier loads (docs/methods.md §27.2). Estimate thread; fixed memory, nothing
// allocates.
#pragma once

#include <array>

#include "core/load/equivalent_pull.hpp"
#include "core/patch/patch.hpp"

namespace slipd {

// Load: force, and torque over its lever. Checked with tests/core/load/torque_path_test.cpp.
struct TorquePathOptions {
  // A load below this share of its maximum has fallen; 0.8 … 0.99. Too small: fields that slipped before and
  // stick now are read as slipping. Too large: noise of a load that rises is taken for a fall.
  double risen_share = 0.97;
  // The load path is followed in steps of contact::kIncrement of the load, above half of the load's maximum.
  // It is straight while the sum of its steps across the load is at most that share, the normal force above
  // the reference grip by at most this one, and the load below its maximum by no more; 0.005 … 0.05. A load
  // kGrown times the largest one at the reference grip makes the present grip the reference. Too small: noise
  // is taken for a regrip, or for a fall. Too large: a rim whose slip has reversed is read as a load near
  // slip.
  double steady_share = 0.012;
};

struct TorquePathState {
  // Whether force and torque are at their maximum in this grasp: else taxels that slipped may stick again, at
  // ratios below friction.
  bool risen = true;
  // Whether force and torque rose in a straight line at a constant grip since the contact began, and are at
  // their maximum.
  bool straight = true;
  // Whether what sticks bears its least load in this grasp, P - Q'/mu for the pull Q': then the slip annulus
  // goes over all traces of earlier loads. Not so in a grip that was tightened, until the load has grown as
  // well.
  bool least_stuck = true;
};

class TorquePath {
 public:
  explicit TorquePath(const TorquePathOptions& options = {}) noexcept : options_(options) {}

  // A new grasp.
  void forget() noexcept { path_ = {}; }
  // The same, and it may carry a load already: its path is not known, and not straight, until forget().
  void lose_sight() noexcept;

  // One frame in contact, in order of time. friction: as far as it is known, > 0; which load is the least
  // that sticks depends on it where the grip has changed.
  TorquePathState follow(const ContactPatch& patch, const EquivalentPullResult& pull,
                         double friction) noexcept;

 private:
  // Force over P along both axes, and torque over P a.
  using Point = std::array<double, 3>;
  // The most load of this grasp, less what noise may be of it. The contact's radius, and with it the lever
  // that makes a force of the torque, changes with the grip: so both parts are kept.
  struct Maximum {
    double shear_n = 0, torque_nm = 0;
  };
  // The frame at which what sticks bore the least.
  struct StuckState {
    double normal_n = 0, pull_n = 0;
  };
  struct Path {
    Maximum most;
    Point last{};          // where the last step ended
    double across = 0;     // lengths across the load, summed over the steps
    double grip_n = 0;     // the reference grip: least P that counts; 0: there was no load
    double at_grip_n = 0;  // the most load at that grip
    bool straight = true;
    StuckState least_stuck;
  };

  void follow_load(const ContactPatch& patch, const EquivalentPullResult& pull,
                   TorquePathState& out) noexcept;
  void follow_direction(const ContactPatch& patch, double load_n, double noise_n) noexcept;
  bool sticks_least(const ContactPatch& patch, const EquivalentPullResult& pull, double friction) noexcept;

  const TorquePathOptions options_;
  Path path_;
};

}  // namespace slipd
