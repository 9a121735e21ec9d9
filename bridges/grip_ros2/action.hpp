// The action of a gripper, as a client of it: goals out; the server's list of goals, and where the fingers
// are, in. One thread's own.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "bridges/grip_ros2/goals.hpp"
#include "bridges/grip_ros2/messages.hpp"
#include "bridges/ros2/dds/node.hpp"
#include "bridges/ros2/dds/subscription.hpp"

namespace slipd::grip_ros2 {

enum class ActionType : std::uint8_t { gripper_command, parallel_gripper_command };
// Of the server's node: requests differ.
enum class Middleware : std::uint8_t { fastdds, cyclonedds };

struct ActionSettings {
  std::string name = "/gripper_controller/gripper_cmd";
  ActionType type = ActionType::gripper_command;
  // Of parallel_gripper_command.
  std::string joint;
  Middleware middleware = Middleware::fastdds;
};

// Where the fingers are and how hard they press, as the gripper's driver has it; NaN: it does not say.
struct Fingers {
  double position, effort;
};

class GripperAction {
 public:
  // `node` must live longer. Throws ros2::DdsError.
  GripperAction(ros2::Node& node, const ActionSettings& settings);
  ~GripperAction();
  GripperAction(const GripperAction&) = delete;
  GripperAction& operator=(const GripperAction&) = delete;

  // Whether a server takes goals of this type.
  bool has_server() const;
  // The goal's number; none: Cyclone has not taken it.
  std::optional<GoalId> send(const Goal& goal);
  // Hands out what has come since the last call, the newest last.
  void take(const std::function<void(const GoalStatus&)>& status,
            const std::function<void(const Fingers&)>& feedback);

 private:
  struct Request;
  template <class T>
  struct RequestOf;
  static std::unique_ptr<Request> make_request(ros2::Node& node, const ActionSettings& settings);

  ActionSettings settings_;
  std::unique_ptr<Request> request_;
  ros2::Subscription status_, feedback_;
  // Keep their memory from message to message.
  GoalStatusArray list_;
  GripperFeedback gripper_feedback_;
  ParallelFeedback parallel_feedback_;
};

}  // namespace slipd::grip_ros2
