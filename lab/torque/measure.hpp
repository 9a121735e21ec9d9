// Contacts that carry force and torque, through the estimators: single frames, grasps loaded in a straight
// line, and grasps with a history. Frames are of core/contact/turning_contact.hpp, margins of the limit
// surface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "lab/frames/torque_frames.hpp"
#include "lab/tally/samples.hpp"
#include "lab/tally/tally.hpp"

namespace lab {

// The error of a margin above the truth that counts as too safe.
inline constexpr double kTurningTooSafe = 0.15;

struct TorqueSetup {
  // Taxels along each side of the pad.
  std::vector<std::size_t> sides{32, 16, 4};
  std::vector<std::string> methods{"auto", "fit", "moments", "registered"};
  // Contacts of each kind of single frames, and grasps of each kind over time.
  std::size_t frames = 400, grasps = 24;
  // Half-width of sensor noise, a share of the contact's largest pressure.
  double noise = 0.01;
  std::uint64_t seed = 1;
  unsigned threads = 2;
};

// Of one row.
struct TorqueTally {
  static constexpr double kNear = 0.7;

  Tally margins{kTurningTooSafe};
  // Of frames with a true margin below kNear.
  Tally near{kTurningTooSafe};
  // Processor time of an estimate, us.
  Samples taken_us;

  void add(const slipd::Estimate& estimate, const slipd::Truth& truth, double estimate_us);
  void add(const TorqueTally& other);
};

struct TurningPoint {
  double truth, gamma;
};

struct TorqueLine {
  std::size_t side = 0;
  std::string method, used;  // as asked for, as taken
  Course course = Course::frame;
  Mix mix = Mix::both;
  bool friction_given = false;
  TorqueTally tally;
  std::vector<TurningPoint> points;  // of single frames
};

// Layouts of few taxels are given the friction, and are seen over time only. `done`: share and layout.
std::vector<TorqueLine> measure_torque(const TorqueSetup& setup,
                                       const std::function<void(double, const char*)>& done);

}  // namespace lab
