// Any bytes that reach slipd-feed-ros2 or stand in a recording as a ROS 2 message: each is a frame of as many
// finite numbers as the sensor has, or none. Input: a byte that chooses the profile, then the message.
#include <cmath>
#include <string>

#include "bridges/feed_ros2/topic_reader.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace slipd::feed_ros2;
using slipd::feed::Outcome;
using slipd::fuzz::demand;

constexpr std::size_t kTaxels = 2;

TopicProfile profile(const std::string& keys, const std::string& frame_id, std::size_t taxels) {
  return parse_topic_profile(
      R"({"description": "x", "tested": "synthetic", "source": "x", "unit": "N", )" + keys + "}", "fuzz",
      {"/topic", frame_id, taxels});
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TopicProfile kProfiles[] = {
      profile(R"("type": "std_msgs/Float32MultiArray", "columns": [0, 1, 2], "array": {"row": 3})", "",
              kTaxels),
      profile(R"("type": "std_msgs/Float32MultiArray", "columns": [1], "time": "received",
                 "array": {"row": 2, "order": "axes", "first": 1, "behind": 1})",
              "", kTaxels),
      profile(R"("type": "sensor_msgs/PointCloud2", "fields": ["x", "y", "z"])", "", kTaxels),
      profile(R"("type": "sensor_msgs/PointCloud2", "fields": ["z"], "time": "sent")", "left", kTaxels),
      profile(R"("type": "geometry_msgs/WrenchStamped")", "wrist", 0)};
  if (size == 0) return 0;
  const TopicProfile& chosen = kProfiles[data[0] % std::size(kProfiles)];
  TopicReader reader(chosen);
  slipd::feed::Reading reading;
  const slipd::feed::Message message{{}, {data + 1, size - 1}, 1'000'000'000};
  if (reader.read(message, reading) != Outcome::frame) {
    demand(!reader.why().empty());
    return 0;
  }
  demand(reading.values.size() == chosen.frames.taxels * static_cast<std::size_t>(chosen.frames.axes));
  for (const float value : reading.values) demand(std::isfinite(value));
  demand(reading.sent_s.has_value() == (chosen.time != TimeOf::received));
  demand(!reading.sent_s || (*reading.sent_s > 0 && std::isfinite(*reading.sent_s)));
  return 0;
}
