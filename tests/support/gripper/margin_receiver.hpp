// A gripper controller's receiver of slipd's CAN messages, by the rules of docs/can.md, for one sensor or
// grasp. Called from one thread; it uses the bus only.
#pragma once

#include <linux/can.h>

#include <chrono>
#include <cstdint>
#include <optional>

#include "core/estimate/estimate.hpp"

namespace slipd::gripper {

using Time = std::chrono::steady_clock::time_point;

class MarginReceiver {
 public:
  // `message`: index of the sensor or grasp; `period`: of SLIP_ESTIMATE. It accepts simulated sensors,
  // because the gripper is simulated, too.
  MarginReceiver(std::uint32_t base_id, std::uint32_t message, std::chrono::nanoseconds period)
      : estimate_{base_id + message},
        alert_{base_id + 0x20 + message},
        heartbeat_{base_id + 0x3F},
        period_(period) {}

  void receive(const can_frame& frame, Time now) noexcept;

  // The valid margin; nothing: it is unknown.
  std::optional<double> margin(Time now) const noexcept;

  // The request of an alert, once per message. Without a number friction is unknown.
  struct GripRequest {
    std::optional<double> grip_increase_n;
  };
  std::optional<GripRequest> take_request() noexcept;

 private:
  struct Line {
    std::uint32_t id = 0;
    std::optional<unsigned> counter = {};
    bool good(const can_frame& frame) noexcept;  // valid, and not a repetition
  };
  Line estimate_, alert_, heartbeat_;
  std::chrono::nanoseconds period_;
  std::optional<Time> received_;
  int to_ignore_ = 0;
  std::optional<double> margin_;
  std::optional<GripRequest> request_;
};

}  // namespace slipd::gripper
