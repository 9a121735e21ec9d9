#include "bridges/feed_ros2/topic.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "bridges/support/clock.hpp"

namespace slipd::feed_ros2 {
namespace {

// After so long without a message of the publisher that is heard, another may take its place. Shorter: two
// that send in turn are both heard. Longer: a publisher that was started again is ignored for so long, as DDS
// notices the end of a killed one only after its lease, 10 to 20 s.
constexpr std::int64_t kSilentNs = 1'000'000'000;

ros2::Subscription subscribe(ros2::Node& node, const TopicProfile& profile) {
  const ros2::ReaderOptions options{profile.qos.depth, profile.qos.reliable};
  switch (profile.type) {
    case TopicType::point_cloud:
      return ros2::Subscription::of<ros2::PointCloud2>(node, profile.topic, options);
    case TopicType::wrench:
      return ros2::Subscription::of<ros2::WrenchStamped>(node, profile.topic, options);
    case TopicType::array:
      break;
  }
  return ros2::Subscription::of<ros2::Float32MultiArray>(node, profile.topic, options);
}

}  // namespace

Topic::Topic(ros2::Node& node, const TopicProfile& profile, feed::Lane& lane)
    : subscription_(subscribe(node, profile)), lane_(lane) {}

void Topic::note_publishers(const ros2::Publications& publications) {
  const std::vector<dds_instance_handle_t> there = subscription_.publishers();
  if (publisher_ != 0 && std::ranges::find(there, publisher_) == there.end()) {
    publisher_ = 0;
    if (!there.empty()) lane_.source_is("");  // the next one begins anew
  }
  std::string trouble = publications.trouble(subscription_);
  if (trouble == trouble_) return;
  trouble_ = std::move(trouble);
  lane_.source_is(trouble_);
}

void Topic::take(const ros2::TakenSample& sample) {
  const std::int64_t now_ns = bridges::monotonic_ns();
  if (publisher_ != sample.publisher) {
    if (publisher_ != 0 && now_ns - heard_ns_ < kSilentNs) return lane_.refuse_second();
    lane_.source_is("");  // its clock is another one
    publisher_ = sample.publisher;
  }
  heard_ns_ = now_ns;
  lane_.take({{}, sample.cdr, sample.sent_ns}, now_ns);
}

void Topic::serve(const ros2::Publications& publications, bool changed) {
  if (const std::uint64_t lost = subscription_.lost(); lost > 0) lane_.lose(lost);
  subscription_.take([this](const ros2::TakenSample& sample) { take(sample); });
  lane_.flush();
  if (subscription_.publishers_changed() || changed) note_publishers(publications);
}

}  // namespace slipd::feed_ros2
