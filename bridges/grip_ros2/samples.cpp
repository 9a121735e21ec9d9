#include "bridges/grip_ros2/samples.hpp"

#include <algorithm>

namespace slipd::ros2 {
namespace {

using grip_ros2::CountedRequest;
using grip_ros2::GripperGoal;
using grip_ros2::JointState;
using grip_ros2::ParallelGoal;

template <class Sequence>
void set_numbers(Sequence& to, const std::vector<double>& from) noexcept {
  set_sequence(to, const_cast<double*>(from.data()), from.size());
}

void fill_joints(const JointState& from, gripper_joints_JointState_& to, SampleMemory& memory) {
  to.stamp = {from.header.stamp.sec, from.header.stamp.nanosec};
  to.frame_id = text_of(from.header.frame_id);
  auto** const names = memory.array<char*>(from.name.size());
  for (std::size_t i = 0; i < from.name.size(); ++i) names[i] = text_of(from.name[i]);
  set_sequence(to.name, names, from.name.size());
  set_numbers(to.position, from.position);
  set_numbers(to.velocity, from.velocity);
  set_numbers(to.effort, from.effort);
}

template <class Sample>
void fill_gripper(const GripperGoal& from, Sample& to) noexcept {
  std::ranges::copy(from.goal_id.uuid, to.goal_id.uuid);
  to.position = from.position;
  to.max_effort = from.max_effort;
}

template <class Sample>
void fill_parallel(const ParallelGoal& from, Sample& to, SampleMemory& memory) {
  std::ranges::copy(from.goal_id.uuid, to.goal_id.uuid);
  fill_joints(from.command, to.command, memory);
}

}  // namespace

void DdsType<GripperGoal>::fill(const GripperGoal& from, Sample& to, SampleMemory& /*memory*/) {
  fill_gripper(from, to);
}

void DdsType<ParallelGoal>::fill(const ParallelGoal& from, Sample& to, SampleMemory& memory) {
  fill_parallel(from, to, memory);
}

const dds_topic_descriptor_t& DdsType<CountedRequest<GripperGoal>>::descriptor() noexcept {
  static const dds_topic_descriptor_t kType = renamed(of_cyclonedds_GripperCommand_SendGoal_Request__desc,
                                                      DdsType<GripperGoal>::descriptor().m_typename);
  return kType;
}

void DdsType<CountedRequest<GripperGoal>>::fill(const CountedRequest<GripperGoal>& from, Sample& to,
                                                SampleMemory& /*memory*/) {
  to.client = from.client;
  to.number = from.number;
  fill_gripper(from.goal, to);
}

const dds_topic_descriptor_t& DdsType<CountedRequest<ParallelGoal>>::descriptor() noexcept {
  static const dds_topic_descriptor_t kType =
      renamed(of_cyclonedds_ParallelGripperCommand_SendGoal_Request__desc,
              DdsType<ParallelGoal>::descriptor().m_typename);
  return kType;
}

void DdsType<CountedRequest<ParallelGoal>>::fill(const CountedRequest<ParallelGoal>& from, Sample& to,
                                                 SampleMemory& memory) {
  to.client = from.client;
  to.number = from.number;
  fill_parallel(from.goal, to, memory);
}

}  // namespace slipd::ros2
