#include "bridges/ros2/dds/samples.hpp"

#include <algorithm>
#include <cstring>
#include <string>

namespace slipd::ros2 {
namespace {

template <std::size_t N, std::size_t MOST>
void copy_bounded(const BoundedString<MOST>& from, char (&to)[N]) noexcept {
  static_assert(N == MOST + 1);
  from.text.copy(to, MOST);
}

void fill_header(const Header& from, std_msgs_msg_dds__Header_& to) noexcept {
  to.stamp.sec = from.stamp.sec;
  to.stamp.nanosec = from.stamp.nanosec;
  to.frame_id = text_of(from.frame_id);
}

void fill_vector(const Vector3& from, geometry_msgs_msg_dds__Vector3_& to) noexcept {
  to.x = from.x;
  to.y = from.y;
  to.z = from.z;
}

template <class Element, std::size_t BYTES, class Sequence>
void fill_gids(const std::vector<Gid<BYTES>>& from, Sequence& to, SampleMemory& memory) {
  Element* const gids = memory.array<Element>(from.size());
  for (std::size_t i = 0; i < from.size(); ++i)
    std::copy(from[i].data.begin(), from[i].data.end(), gids[i].data);
  set_sequence(to, gids, from.size());
}

template <class CGid, class CNode, std::size_t BYTES, class Sample>
void fill_participant(const ParticipantEntitiesInfo<BYTES>& from, Sample& to, SampleMemory& memory) {
  std::copy(from.gid.data.begin(), from.gid.data.end(), to.gid.data);
  CNode* const nodes = memory.array<CNode>(from.node_entities_info_seq.size());
  for (std::size_t i = 0; i < from.node_entities_info_seq.size(); ++i) {
    const NodeEntitiesInfo<BYTES>& node = from.node_entities_info_seq[i];
    copy_bounded(node.node_namespace, nodes[i].node_namespace);
    copy_bounded(node.node_name, nodes[i].node_name);
    fill_gids<CGid>(node.reader_gid_seq, nodes[i].reader_gid_seq, memory);
    fill_gids<CGid>(node.writer_gid_seq, nodes[i].writer_gid_seq, memory);
  }
  set_sequence(to.node_entities_info_seq, nodes, from.node_entities_info_seq.size());
}

void fill_status(const DiagnosticStatus& from, diagnostic_msgs_msg_dds__DiagnosticStatus_& to,
                 SampleMemory& memory) {
  to.level = from.level.value;
  to.name = text_of(from.name);
  to.message = text_of(from.message);
  to.hardware_id = text_of(from.hardware_id);
  auto* const values = memory.array<diagnostic_msgs_msg_dds__KeyValue_>(from.values.size());
  for (std::size_t i = 0; i < from.values.size(); ++i)
    values[i] = {text_of(from.values[i].key), text_of(from.values[i].value)};
  set_sequence(to.values, values, from.values.size());
}

}  // namespace

void DdsType<Float32>::fill(const Float32& from, Sample& to, SampleMemory& /*memory*/) {
  to.data = from.data;
}

void DdsType<WrenchStamped>::fill(const WrenchStamped& from, Sample& to, SampleMemory& /*memory*/) {
  fill_header(from.header, to.header);
  fill_vector(from.wrench.force, to.wrench.force);
  fill_vector(from.wrench.torque, to.wrench.torque);
}

void DdsType<PointCloud2>::fill(const PointCloud2& from, Sample& to, SampleMemory& memory) {
  fill_header(from.header, to.header);
  to.height = from.height;
  to.width = from.width;
  auto* const fields = memory.array<sensor_msgs_msg_dds__PointField_>(from.point_fields.size());
  for (std::size_t i = 0; i < from.point_fields.size(); ++i) {
    const PointField& field = from.point_fields[i];
    fields[i] = {text_of(field.name), field.offset, field.datatype, field.count};
  }
  set_sequence(to.fields, fields, from.point_fields.size());
  to.is_bigendian = from.is_bigendian;
  to.point_step = from.point_step;
  to.row_step = from.row_step;
  set_sequence(to.data, const_cast<std::uint8_t*>(from.data.data()), from.data.size());
  to.is_dense = from.is_dense;
}

void DdsType<DiagnosticArray>::fill(const DiagnosticArray& from, Sample& to, SampleMemory& memory) {
  fill_header(from.header, to.header);
  auto* const statuses = memory.array<diagnostic_msgs_msg_dds__DiagnosticStatus_>(from.status.size());
  for (std::size_t i = 0; i < from.status.size(); ++i) fill_status(from.status[i], statuses[i], memory);
  set_sequence(to.status, statuses, from.status.size());
}

void DdsType<SlipEstimate>::fill(const SlipEstimate& from, Sample& to, SampleMemory& /*memory*/) {
  fill_header(from.header, to.header);
  to.name = text_of(from.name);
  to.state = from.state;
  to.alert = from.alert;
  to.sliding = from.sliding;
  to.simulated = from.simulated;
  to.seq = from.seq;
  to.dropped = from.dropped;
  to.age = from.age;
  to.margin = from.margin;
  to.margin_sigma = from.margin_sigma;
  to.margin_low = from.margin_low;
  to.friction = from.friction;
  to.friction_sigma = from.friction_sigma;
  to.normal_force = from.normal_force;
  to.shear_force = from.shear_force;
  to.shear_force_x = from.shear_force_x;
  to.shear_force_y = from.shear_force_y;
  to.torque = from.torque;
  to.torque_sigma = from.torque_sigma;
  to.center_x = from.center_x;
  to.center_y = from.center_y;
  to.radius = from.radius;
  to.time_to_slip = from.time_to_slip;
  to.grip_increase = from.grip_increase;
  to.grip_increase_sigma = from.grip_increase_sigma;
  to.sliding_for = from.sliding_for;
}

void DdsType<ParticipantEntitiesInfo<kGidBytes>>::fill(const ParticipantEntitiesInfo<kGidBytes>& from,
                                                       Sample& to, SampleMemory& memory) {
  fill_participant<rmw_dds_common_msg_dds__Gid_, rmw_dds_common_msg_dds__NodeEntitiesInfo_>(from, to, memory);
}

void DdsType<ParticipantEntitiesInfo<kHumbleGidBytes>>::fill(
    const ParticipantEntitiesInfo<kHumbleGidBytes>& from, Sample& to, SampleMemory& memory) {
  fill_participant<rmw_dds_common_humble_msg_dds__Gid_, rmw_dds_common_humble_msg_dds__NodeEntitiesInfo_>(
      from, to, memory);
}

}  // namespace slipd::ros2
