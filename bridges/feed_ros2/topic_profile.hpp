// What the messages of a ROS 2 topic are: a profile, as topic.schema.json describes its keys. Without DDS, so
// that slipctl uses it for recordings, too. Any thread that may allocate.
#pragma once

#include <slipd.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace slipd::feed_ros2 {

enum class TopicType : unsigned char { point_cloud, wrench, array };

// "sensor_msgs/msg/PointCloud2": as recordings name it, and messages/messages.hpp.
const char* message_name(TopicType type) noexcept;

// When a message's frame was measured.
enum class TimeOf : unsigned char {
  stamp,    // header.stamp
  sent,     // when the publisher handed it over, by DDS or the recording
  received  // when it came
};

// Where the numbers of a Float32MultiArray are. Of the taxel t, the column c is data[first + t row + c], or
// with `by_axes` data[first + c taxels + t].
struct ArrayLayout {
  std::size_t first = 0;
  std::size_t row = 0;  // numbers of each taxel
  bool by_axes = false;
  std::size_t behind = 0;  // numbers behind the last
};

struct Qos {
  bool reliable = false;
  int depth = 10;
};

struct TopicProfile {
  std::string topic;  // "/left/taxels"; empty: the settings say it
  TopicType type = TopicType::array;
  std::vector<std::string> fields;   // of the axes: a point's fields, or "force.x" of a wrench
  std::vector<std::size_t> columns;  // of the axes, in an array
  ArrayLayout array;
  TimeOf time = TimeOf::sent;
  std::string frame_id;  // messages of others are not of this sensor; empty: all are
  Qos qos;
  slipd_frames frames{};  // of the hello to slipd
};

// What of the settings changes a profile.
struct TopicInstance {
  std::string topic;       // empty: the profile's
  std::string frame_id;    // empty: all
  std::size_t taxels = 0;  // 0: the profile's
};

// Throws SettingsError, one line for each error.
TopicProfile parse_topic_profile(const std::string& text, const std::string& name,
                                 const TopicInstance& instance);

// Reads the file `name`, if it has a slash. Else reads NAME.json from /etc/slipd/topics, else from the
// shipped profiles. Throws SettingsError.
TopicProfile find_topic_profile(const std::string& name, const TopicInstance& instance);

}  // namespace slipd::feed_ros2
