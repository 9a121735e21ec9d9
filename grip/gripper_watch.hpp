// What a gripper tells of itself beside what the sensors feel: a force that is another shows that a zero, a
// calibration or the gripper is wrong; a width that changes while something is held, that the object gives
// way or slips out. Tells only: the law does not hear of it. No clock; one thread's own.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "grip/grippers/gripper.hpp"
#include "grip/law.hpp"

namespace slipd::grip {

class GripperWatch {
 public:
  // fingers: that `normal_n` of a reading is the sum of, 1 or more.
  explicit GripperWatch(int fingers) : fingers_(fingers) {}

  // For people: what contradicts; empty: nothing. `gripping`: whether the fingers hold something; `now_ns` of
  // a steady clock.
  const std::string& judge(const GripperFacts& facts, const Reading& reading, bool gripping,
                           std::int64_t now_ns);
  // How far the fingers have opened since they hold something, mm; negative: closed.
  std::optional<double> width_change_mm() const noexcept { return grip_.width_change_mm; }

 private:
  void watch_force(const GripperFacts& facts, const Reading& reading, std::int64_t now_ns);
  void watch_width(const GripperFacts& facts, std::int64_t now_ns);

  // What ends with the grip.
  struct Grip {
    std::optional<std::int64_t> since_ns, unlike_since_ns;
    std::optional<double> first_width_mm, width_change_mm;
    std::string force_trouble, width_trouble;
  };

  int fingers_;
  Grip grip_;
};

}  // namespace slipd::grip
