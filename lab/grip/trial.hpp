// One task, done by slipd and slipd-grip in MuJoCo's physics, and by a gripper that is deaf.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lab/grip/programs.hpp"
#include "lab/grip/task.hpp"
#include "lab/grip/world.hpp"

namespace lab::grip {

// The margin at one moment.
struct Probe {
  double time_s = 0;
  TrueMargins truth;
  std::optional<double> gamma;      // slipd's; none: it did not know
  std::optional<double> gamma_low;  // the same
  double force_n = 0;               // of each finger
};

struct TrialResult {
  Task task;
  bool dropped = false;
  double moved_m = 0;       // from the lift to the end
  double mean_force_n = 0;  // from the end of the lift
  double most_force_n = 0;
  double known_share = 0;             // of the frames of the hold, with a margin
  std::map<std::string, int> states;  // slipd's, of the frames of the hold
  std::vector<Probe> probes;
  // From a frame in which all slides to the first order that is higher, frames; 0: its own answer.
  std::vector<double> reactions_frames;
  int slides_unanswered = 0;  // that ended, or began at the most force, without one
};

struct TrialOptions {
  BedOptions bed;
  WorldOptions world;
  double noise_n = 0.005;  // of a taxel's reading, half width
  int probes = 5;
  bool verbose = false;
};

TrialResult hold(const Task& task, const TrialOptions& options);
// With one force throughout, N.
TrialResult hold_deaf(const Task& task, double force_n, const TrialOptions& options);

}  // namespace lab::grip
