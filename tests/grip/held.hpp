// slipd-grip's law without a gripper and without a clock, and readings for it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>

#include "grip/law.hpp"

namespace slipd::grip {

inline constexpr std::int64_t kFrameNs = 5'000'000;
inline constexpr double kShearN = 6;
inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

inline Reading margin_of(double gamma) {
  return {.known = true,
          .bounded = true,
          .contact = true,
          .gamma = gamma,
          .gamma_low = gamma,
          .sigma = 0,
          .normal_n = 10,
          .shear_n = kShearN,
          .increase_n = kNone,
          .time_to_slip_s = kNone};
}

inline Reading unknown(std::optional<bool> contact) {
  Reading reading = margin_of(kNone);
  reading.known = reading.bounded = false;
  reading.contact = contact;
  return reading;
}

// A law and its clock.
struct Held {
  LawSettings settings;
  Law law{settings};
  std::int64_t now_ns = 0;

  explicit Held(const LawSettings& with = {}) : settings(with) {}
  Order step(const Reading& reading, Wish wish = Wish::none, bool answers = true) {
    now_ns += kFrameNs;
    return law.step(reading, wish, answers, now_ns);
  }
  Order steps(const Reading& reading, double for_s) {
    Order order;
    for (const auto until = now_ns + static_cast<std::int64_t>(for_s * 1e9); now_ns < until;)
      order = step(reading);
    return order;
  }
  // Closed on an object whose pull needs `needed_n` of a finger for a margin of 0.
  void hold(double needed_n, double for_s) {
    for (const auto until = now_ns + static_cast<std::int64_t>(for_s * 1e9); now_ns < until;)
      step(margin_of(std::max(0.0, 1 - needed_n / std::max(0.1, law.force_n()))));
  }
  void close() {
    step(unknown(false), Wish::close);
    step(margin_of(1));
  }
};

}  // namespace slipd::grip
