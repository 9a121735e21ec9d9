// What happens to one object in a gripper: its shape, mass and friction, and the loads of some seconds. Drawn
// at random, the same for the same number. Everything is in the frame of the hand: a hand that is shaken or
// tilted is a weight that grows or turns.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace lab::grip {

enum class Shape : std::uint8_t { box, cylinder, sphere };

struct Load {
  enum class Kind : std::uint8_t { step, tap, tilt, shake, friction_fall };
  Kind kind;
  double at_s = 0, for_s = 0;
  // Share of the weight; of tilt an angle, rad; of friction_fall the share that is lost for good.
  double size = 0;
  // Of step and tap in the plane of the pads, from the weight's direction; of tilt the axis; rad.
  double angle = 0;
};

struct Task {
  std::uint64_t number = 0;
  Shape shape = Shape::box;
  double half_width_m = 0.02;  // half of what is between the fingers
  double mass_kg = 0.2;
  std::array<double, 3> center_m{};  // of mass, from the middle of the pads
  double friction = 0.5;             // at the beginning
  double lift_s = 0.5;               // for which the weight comes upon the fingers
  std::vector<Load> loads;
  double length_s = 0;

  // Force on the object besides the fingers', N, in the hand's frame: x from the left finger to the right
  // one, z up.
  std::array<double, 3> load_n(double time_s) const;
  double friction_at(double time_s) const;
  double lowest_friction() const;
};

// Times of all tasks, s: the order to close; the beginning of the lift.
inline constexpr double kCloseAt = 0.1, kLiftAt = 1.2;

Task draw_task(std::uint64_t number);

std::string describe(const Task& task);

}  // namespace lab::grip
