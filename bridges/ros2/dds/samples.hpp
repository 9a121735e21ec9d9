// Messages as samples of the types that idlc makes from idl/ros2.idl, for dds_write(). Any thread.
//
// Decision: Cyclone serialises these, by its stable interface. Writing the bytes of cdr.hpp as they are would
// need an implementation of ddsi_sertype, which is internal and changes between releases. A test compares the
// bytes of both.
#pragma once

#include <dds/dds.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <string>
#include <vector>

#include "bridges/ros2/messages/messages.hpp"
#include "ros2.h"  // made by idlc

namespace slipd::ros2 {

// Memory for the sequences of one sample; texts and bytes stay where the message has them.
class SampleMemory {
 public:
  // Zeroed elements that live as long as this object.
  template <class T>
  T* array(std::size_t elements) {
    void* const memory = resource_.allocate(elements * sizeof(T) + 1, alignof(T));
    return new (memory) T[elements]();
  }

 private:
  // Enough for all samples but diagnostics of many sensors.
  static constexpr std::size_t kUsualBytes = 1024;
  std::array<std::byte, kUsualBytes> usual_;
  std::pmr::monotonic_buffer_resource resource_{usual_.data(), usual_.size()};
};

// What a sample points to: dds_write() does not change what it reads.
inline char* text_of(const std::string& text) noexcept {
  return const_cast<char*>(text.c_str());
}

// Sequences of C have the same members under other names.
template <class Sequence, class Element>
void set_sequence(Sequence& to, Element* elements, std::size_t length) noexcept {
  to._maximum = to._length = static_cast<std::uint32_t>(length);
  to._buffer = elements;
  to._release = false;
}

// `type` under another name, which has to live as long.
inline dds_topic_descriptor_t renamed(const dds_topic_descriptor_t& type, const char* name) noexcept {
  dds_topic_descriptor_t other = type;
  other.m_typename = name;
  return other;
}

// For each message that is a topic: the sample's type, its descriptor, and `fill`. A sample points into its
// message.
template <class T>
struct DdsType;

template <>
struct DdsType<Float32> {
  using Sample = std_msgs_msg_dds__Float32_;
  static const dds_topic_descriptor_t& descriptor() noexcept { return std_msgs_msg_dds__Float32__desc; }
  static void fill(const Float32& from, Sample& to, SampleMemory& memory);
};
// What others write, and slipd-feed-ros2 reads as bytes: no sample is filled.
template <>
struct DdsType<Float32MultiArray> {
  using Sample = std_msgs_msg_dds__Float32MultiArray_;
  static const dds_topic_descriptor_t& descriptor() noexcept {
    return std_msgs_msg_dds__Float32MultiArray__desc;
  }
};
template <>
struct DdsType<WrenchStamped> {
  using Sample = geometry_msgs_msg_dds__WrenchStamped_;
  static const dds_topic_descriptor_t& descriptor() noexcept {
    return geometry_msgs_msg_dds__WrenchStamped__desc;
  }
  static void fill(const WrenchStamped& from, Sample& to, SampleMemory& memory);
};
template <>
struct DdsType<PointCloud2> {
  using Sample = sensor_msgs_msg_dds__PointCloud2_;
  static const dds_topic_descriptor_t& descriptor() noexcept {
    return sensor_msgs_msg_dds__PointCloud2__desc;
  }
  static void fill(const PointCloud2& from, Sample& to, SampleMemory& memory);
};
template <>
struct DdsType<DiagnosticArray> {
  using Sample = diagnostic_msgs_msg_dds__DiagnosticArray_;
  static const dds_topic_descriptor_t& descriptor() noexcept {
    return diagnostic_msgs_msg_dds__DiagnosticArray__desc;
  }
  static void fill(const DiagnosticArray& from, Sample& to, SampleMemory& memory);
};
template <>
struct DdsType<SlipEstimate> {
  using Sample = slipd_msgs_msg_dds__SlipEstimate_;
  static const dds_topic_descriptor_t& descriptor() noexcept {
    return slipd_msgs_msg_dds__SlipEstimate__desc;
  }
  static void fill(const SlipEstimate& from, Sample& to, SampleMemory& memory);
};
template <>
struct DdsType<ParticipantEntitiesInfo<kGidBytes>> {
  using Sample = rmw_dds_common_msg_dds__ParticipantEntitiesInfo_;
  static const dds_topic_descriptor_t& descriptor() noexcept {
    return rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc;
  }
  static void fill(const ParticipantEntitiesInfo<kGidBytes>& from, Sample& to, SampleMemory& memory);
};
template <>
struct DdsType<ParticipantEntitiesInfo<kHumbleGidBytes>> {
  using Sample = rmw_dds_common_humble_msg_dds__ParticipantEntitiesInfo_;
  static const dds_topic_descriptor_t& descriptor() noexcept {
    return rmw_dds_common_humble_msg_dds__ParticipantEntitiesInfo__desc;
  }
  static void fill(const ParticipantEntitiesInfo<kHumbleGidBytes>& from, Sample& to, SampleMemory& memory);
};

}  // namespace slipd::ros2
