// Contacts that carry force and torque, through the estimators: single frames, grasps loaded in a straight
// line, and grasps with a history. Frames are of core/contact/turning_contact.hpp, margins of the limit
// surface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "lab/error_statistics.hpp"

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

// What a contact carries: a pull alone, both, or a torque with little pull.
enum class Mix : std::uint8_t { pull, both, turn };
// How it came to that.
enum class Course : std::uint8_t {
  frame,    // one frame of a load that rose in a straight line, without tracking
  ramp,     // a grip that closes, then such a load up to slip, with tracking
  history,  // then loads that turn, fall, reverse, and a grip that changes
};
const char* name_of(Mix mix) noexcept;
const char* name_of(Course course) noexcept;

// Of one row.
class TurningTally {
 public:
  void add(const slipd::Estimate& estimate, slipd::Truth truth, double taken_us);
  void add(const TurningTally& other);

  const ErrorStatistics& margins() const noexcept { return margins_; }
  // Of the answers: the share more than kTurningTooSafe above the truth, and the most above it.
  double too_safe() const noexcept;
  double most_too_safe() const noexcept { return most_above_; }
  // Mean of the answers less the truth; NaN without answers.
  double bias() const noexcept;
  // Of answers with learnt friction at true margins below kNear: mean relative error, and the share off by
  // more than a tenth.
  double friction_error() const noexcept;
  double friction_wrong() const noexcept;
  // Answered, of the frames with a true margin below kNear.
  double answered_near() const noexcept;
  double median_us() const;

 private:
  static constexpr double kNear = 0.7;

  ErrorStatistics margins_;
  double off_ = 0, above_ = 0, most_above_ = 0, near_ = 0, near_answered_ = 0;
  double frictions_ = 0, friction_errors_ = 0, frictions_wrong_ = 0;
  std::vector<float> taken_us_;
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
  TurningTally tally;
  std::vector<TurningPoint> points;  // of single frames
};

// Layouts of few taxels are given the friction, and are seen over time only. `done`: share and layout.
std::vector<TorqueLine> measure_torque(const TorqueSetup& setup,
                                       const std::function<void(double, const char*)>& done);

}  // namespace lab
