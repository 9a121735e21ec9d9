#include "bridges/grip_ros2/samples.hpp"

#include <algorithm>

namespace slipd::ros2 {
namespace {

using grip_ros2::CountedRequest;
using grip_ros2::GripperGoal;
using grip_ros2::JointState;
using grip_ros2::ParallelGoal;

// dds_write() does not change what it reads.
template <class Sequence, class Element>
void set_sequence(Sequence& to, Element* elements, std::size_t length) noexcept {
  to._maximum = to._length = static_cast<std::uint32_t>(length);
  to._buffer = elements;
  to._release = false;
}

template <class Sequence>
void set_numbers(Sequence& to, const std::vector<double>& from) noexcept {
  set_sequence(to, const_cast<double*>(from.data()), from.size());
}

void fill_joints(const JointState& from, gripper_joints_JointState_& to, SampleMemory& memory) {
  to.stamp = {from.header.stamp.sec, from.header.stamp.nanosec};
  to.frame_id = const_cast<char*>(from.header.frame_id.c_str());
  auto** const names = memory.array<char*>(from.name.size());
  for (std::size_t i = 0; i < from.name.size(); ++i) names[i] = const_cast<char*>(from.name[i].c_str());
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

// `type` under the name of another.
dds_topic_descriptor_t renamed(const dds_topic_descriptor_t& type, const dds_topic_descriptor_t& as) {
  return {type.m_size,   type.m_align,          type.m_flagset,    type.m_nkeys,
          as.m_typename, type.m_keys,           type.m_nops,       type.m_ops,
          type.m_meta,   type.type_information, type.type_mapping, type.restrict_data_representation};
}

}  // namespace

void DdsType<GripperGoal>::fill(const GripperGoal& from, Sample& to, SampleMemory& /*memory*/) {
  fill_gripper(from, to);
}

void DdsType<ParallelGoal>::fill(const ParallelGoal& from, Sample& to, SampleMemory& memory) {
  fill_parallel(from, to, memory);
}

const dds_topic_descriptor_t& DdsType<CountedRequest<GripperGoal>>::descriptor() noexcept {
  static const dds_topic_descriptor_t kType =
      renamed(of_cyclonedds_GripperCommand_SendGoal_Request__desc, DdsType<GripperGoal>::descriptor());
  return kType;
}

void DdsType<CountedRequest<GripperGoal>>::fill(const CountedRequest<GripperGoal>& from, Sample& to,
                                                SampleMemory& /*memory*/) {
  to.client = from.client;
  to.number = from.number;
  fill_gripper(from.goal, to);
}

const dds_topic_descriptor_t& DdsType<CountedRequest<ParallelGoal>>::descriptor() noexcept {
  static const dds_topic_descriptor_t kType = renamed(
      of_cyclonedds_ParallelGripperCommand_SendGoal_Request__desc, DdsType<ParallelGoal>::descriptor());
  return kType;
}

void DdsType<CountedRequest<ParallelGoal>>::fill(const CountedRequest<ParallelGoal>& from, Sample& to,
                                                 SampleMemory& memory) {
  to.client = from.client;
  to.number = from.number;
  fill_parallel(from.goal, to, memory);
}

}  // namespace slipd::ros2
