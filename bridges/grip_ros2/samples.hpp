// The messages of actions as samples of the types that idlc makes from idl/gripper.idl; see
// bridges/ros2/dds/samples.hpp. Any thread.
#pragma once

#include "bridges/grip_ros2/messages.hpp"
#include "bridges/ros2/dds/samples.hpp"
#include "gripper.h"  // made by idlc

namespace slipd::ros2 {

template <>
struct DdsType<grip_ros2::GripperGoal> {
  using Sample = control_msgs_action_dds__GripperCommand_SendGoal_Request_;
  static const dds_topic_descriptor_t& descriptor() noexcept {
    return control_msgs_action_dds__GripperCommand_SendGoal_Request__desc;
  }
  static void fill(const grip_ros2::GripperGoal& from, Sample& to, SampleMemory& memory);
};
template <>
struct DdsType<grip_ros2::ParallelGoal> {
  using Sample = control_msgs_action_dds__ParallelGripperCommand_SendGoal_Request_;
  static const dds_topic_descriptor_t& descriptor() noexcept {
    return control_msgs_action_dds__ParallelGripperCommand_SendGoal_Request__desc;
  }
  static void fill(const grip_ros2::ParallelGoal& from, Sample& to, SampleMemory& memory);
};
template <>
struct DdsType<grip_ros2::CountedRequest<grip_ros2::GripperGoal>> {
  using Sample = of_cyclonedds_GripperCommand_SendGoal_Request_;
  static const dds_topic_descriptor_t& descriptor() noexcept;
  static void fill(const grip_ros2::CountedRequest<grip_ros2::GripperGoal>& from, Sample& to,
                   SampleMemory& memory);
};
template <>
struct DdsType<grip_ros2::CountedRequest<grip_ros2::ParallelGoal>> {
  using Sample = of_cyclonedds_ParallelGripperCommand_SendGoal_Request_;
  static const dds_topic_descriptor_t& descriptor() noexcept;
  static void fill(const grip_ros2::CountedRequest<grip_ros2::ParallelGoal>& from, Sample& to,
                   SampleMemory& memory);
};
// What the action's server writes, and is read as bytes.
template <>
struct DdsType<grip_ros2::GripperFeedback> {
  static const dds_topic_descriptor_t& descriptor() noexcept {
    return control_msgs_action_dds__GripperCommand_FeedbackMessage__desc;
  }
};
template <>
struct DdsType<grip_ros2::ParallelFeedback> {
  static const dds_topic_descriptor_t& descriptor() noexcept {
    return control_msgs_action_dds__ParallelGripperCommand_FeedbackMessage__desc;
  }
};
template <>
struct DdsType<grip_ros2::GoalStatusArray> {
  static const dds_topic_descriptor_t& descriptor() noexcept {
    return action_msgs_msg_dds__GoalStatusArray__desc;
  }
};

}  // namespace slipd::ros2
