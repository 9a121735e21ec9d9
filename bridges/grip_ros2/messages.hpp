// The messages of ROS 2's actions for grippers, control_msgs/action/GripperCommand and
// ParallelGripperCommand, as they go over DDS. Names and fields are those of control_msgs, action_msgs and
// unique_identifier_msgs as released with Humble and Jazzy; what an action consists of is
// https://design.ros2.org/articles/actions.html. Values; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "bridges/ros2/messages/messages.hpp"

namespace slipd::grip_ros2 {

// No hashes: nodes match by the types' names.
inline constexpr std::string_view kNoHash;

struct GoalId {
  static constexpr std::string_view kName = "unique_identifier_msgs/msg/UUID";
  std::array<std::uint8_t, 16> uuid{};
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("uuid", m.uuid);
  }
  bool operator==(const GoalId&) const = default;
};

// sensor_msgs/msg/JointState.
struct JointState {
  static constexpr std::string_view kName = "sensor_msgs/msg/JointState";
  ros2::Header header;
  std::vector<std::string> name;
  std::vector<double> position;  // m or rad
  std::vector<double> velocity;  // m/s or rad/s
  std::vector<double> effort;    // N or N m
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("header", m.header);
    visit("name", m.name);
    visit("position", m.position);
    visit("velocity", m.velocity);
    visit("effort", m.effort);
  }
};

// A goal of a gripper with one number for where it is.
struct GripperGoal {
  static constexpr std::string_view kName = "control_msgs/action/GripperCommand_SendGoal_Request";
  static constexpr std::string_view kTypeHash = kNoHash;
  GoalId goal_id;
  double position = 0;    // m or rad, as the gripper's driver has it
  double max_effort = 0;  // N or N m
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("goal_id", m.goal_id);
    visit("position", m.position);
    visit("max_effort", m.max_effort);
  }
};

// A goal of a gripper by the names of its joints.
struct ParallelGoal {
  static constexpr std::string_view kName = "control_msgs/action/ParallelGripperCommand_SendGoal_Request";
  static constexpr std::string_view kTypeHash = kNoHash;
  GoalId goal_id;
  JointState command;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("goal_id", m.goal_id);
    visit("command", m.command);
  }
};

// A request as rmw_cyclonedds has it: who asks, and how often it has.
template <class Goal>
struct CountedRequest {
  static constexpr std::string_view kName = Goal::kName;
  static constexpr std::string_view kTypeHash = kNoHash;
  std::uint64_t client = 0;  // any that no other client of the action has
  std::int64_t number = 0;
  Goal goal;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("client", m.client);
    visit("number", m.number);
    Goal::fields(m.goal, visit);
  }
};

struct GripperFeedback {
  static constexpr std::string_view kName = "control_msgs/action/GripperCommand_FeedbackMessage";
  static constexpr std::string_view kTypeHash = kNoHash;
  GoalId goal_id;
  double position = 0;  // as in the goal
  double effort = 0;    // as in the goal
  bool stalled = false;
  bool reached_goal = false;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("goal_id", m.goal_id);
    visit("position", m.position);
    visit("effort", m.effort);
    visit("stalled", m.stalled);
    visit("reached_goal", m.reached_goal);
  }
};

struct ParallelFeedback {
  static constexpr std::string_view kName = "control_msgs/action/ParallelGripperCommand_FeedbackMessage";
  static constexpr std::string_view kTypeHash = kNoHash;
  GoalId goal_id;
  JointState state;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("goal_id", m.goal_id);
    visit("state", m.state);
  }
};

// How a goal is: action_msgs/msg/GoalStatus.
struct GoalStatus {
  static constexpr std::string_view kName = "action_msgs/msg/GoalStatus";
  static constexpr std::int8_t kAborted = 6;
  GoalId goal_id;
  ros2::Time stamp;
  std::int8_t status = 0;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("goal_id", m.goal_id);
    visit("stamp", m.stamp);
    visit("status", m.status);
  }
};

// All goals that an action's server has accepted and not yet forgotten.
struct GoalStatusArray {
  static constexpr std::string_view kName = "action_msgs/msg/GoalStatusArray";
  static constexpr std::string_view kTypeHash = kNoHash;
  std::vector<GoalStatus> status_list;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("status_list", m.status_list);
  }
};

}  // namespace slipd::grip_ros2
