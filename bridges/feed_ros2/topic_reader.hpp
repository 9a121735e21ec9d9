// Bytes of a ROS 2 message (CDR) → one frame's values, as a profile describes it, or why it has none. No DDS,
// no clock. One thread at a time; any bytes are valid input.
#pragma once

#include <cstddef>
#include <string>
#include <utility>

#include "bridges/feed_lane/message_reader.hpp"
#include "bridges/feed_ros2/topic_profile.hpp"
#include "bridges/ros2/messages/messages.hpp"

namespace slipd::feed_ros2 {

class TopicReader final : public feed::MessageReader {
 public:
  explicit TopicReader(TopicProfile profile) : profile_(std::move(profile)) {}

  // `message.body`: with its encapsulation header.
  feed::Outcome read(const feed::Message& message, feed::Reading& out) override;

 private:
  feed::Outcome read_array(feed::Bytes body, feed::Reading& out);
  feed::Outcome read_wrench(feed::Bytes body, feed::Reading& out);
  feed::Outcome read_cloud(feed::Bytes body, feed::Reading& out);
  feed::Outcome cloud_values(feed::Reading& out);
  feed::Outcome check_header(const ros2::Header& header);
  feed::Outcome set_time(const feed::Message& message, feed::Reading& out);
  std::size_t taxels() const noexcept { return profile_.frames.taxels; }

  TopicProfile profile_;
  ros2::Time stamp_;  // of the message that is read
  // Keep their memory from message to message.
  ros2::Float32MultiArray array_;
  ros2::WrenchStamped wrench_;
  ros2::PointCloud2 cloud_;
};

}  // namespace slipd::feed_ros2
