#include "grip/gripper_watch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace slipd::grip {
namespace {

constexpr double kNsPerS = 1e9;
// Forces that differ by more than this factor for so long, s, are none that a calibration leaves; below this,
// N, a zero's drift is as large.
constexpr double kUnlike = 2, kUnlikeForS = 1, kLeastN = 1;
// The width is that of the object once the fingers have settled, s. Grippers tell it in steps of up to 0.4
// mm; pads give by some tenths.
constexpr double kSettledS = 0.5, kChangedMm = 1.5;

double seconds(std::int64_t since_ns, std::int64_t now_ns) noexcept {
  return static_cast<double>(now_ns - since_ns) / kNsPerS;
}

std::string newtons(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

}  // namespace

const std::string& GripperWatch::judge(const GripperFacts& facts, const Reading& reading, bool gripping,
                                       std::int64_t now_ns) {
  if (!gripping || reading.contact == false) {
    grip_ = {};
  } else {
    if (!grip_.since_ns) grip_.since_ns = now_ns;
    watch_force(facts, reading, now_ns);
    watch_width(facts, now_ns);
  }
  return grip_.force_trouble.empty() ? grip_.width_trouble : grip_.force_trouble;
}

void GripperWatch::watch_force(const GripperFacts& facts, const Reading& reading, std::int64_t now_ns) {
  const double felt_n = reading.normal_n / fingers_;
  const bool known = facts.force_n && reading.contact && std::isfinite(felt_n);
  const double more = known ? std::max(*facts.force_n, felt_n) : 0,
               less = known ? std::min(*facts.force_n, felt_n) : 0;
  if (more < kLeastN || more < kUnlike * less) {
    grip_.unlike_since_ns.reset();
    grip_.force_trouble.clear();
    return;
  }
  if (!grip_.unlike_since_ns) grip_.unlike_since_ns = now_ns;
  if (seconds(*grip_.unlike_since_ns, now_ns) < kUnlikeForS || !grip_.force_trouble.empty()) return;
  grip_.force_trouble =
      "the gripper measures " + newtons(*facts.force_n) + " N a finger, and the sensors feel " +
      newtons(felt_n) +
      " N: one of them is wrong; open, then slipctl rebias; slipctl calibrate, with a weight";
}

void GripperWatch::watch_width(const GripperFacts& facts, std::int64_t now_ns) {
  if (!facts.width_mm || seconds(*grip_.since_ns, now_ns) < kSettledS) return;
  if (!grip_.first_width_mm) grip_.first_width_mm = *facts.width_mm;
  grip_.width_change_mm = *facts.width_mm - *grip_.first_width_mm;
  if (std::fabs(*grip_.width_change_mm) < kChangedMm) {
    grip_.width_trouble.clear();
  } else if (grip_.width_trouble.empty()) {
    grip_.width_trouble =
        *grip_.width_change_mm < 0
            ? "the fingers have closed while they hold: the object gives way, or slips out"
            : "the fingers have opened while they hold: something forces them apart, or the "
              "gripper gives way";
  }
}

}  // namespace slipd::grip
