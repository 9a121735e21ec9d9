// One sensor's topic: its messages go to the sensor's lane. All of it runs in the sources' thread.
//
// One publisher at a time: a sensor is measured by one device. The first that sends is heard until it has
// gone or has been silent for a second; messages of others are counted until then.
#pragma once

#include <cstdint>
#include <string>

#include "bridges/feed_lane/lane.hpp"
#include "bridges/feed_ros2/topic_profile.hpp"
#include "bridges/ros2/dds/subscription.hpp"

namespace slipd::feed_ros2 {

class Topic {
 public:
  // `node` and `lane` must live longer. Throws ros2::DdsError.
  Topic(ros2::Node& node, const TopicProfile& profile, feed::Lane& lane);

  dds_entity_t entity() const noexcept { return subscription_.entity(); }
  // Takes what has come. `changed`: a publisher of some topic has come or gone; the lane then says whether
  // this one has one.
  void serve(const ros2::Publications& publications, bool changed);

 private:
  void note_publishers(const ros2::Publications& publications);
  void take(const ros2::TakenSample& sample);

  ros2::Subscription subscription_;
  feed::Lane& lane_;
  dds_instance_handle_t publisher_ = 0;  // 0: the next that sends
  std::int64_t heard_ns_ = 0;            // when it sent last, CLOCK_MONOTONIC
  std::string trouble_;
};

}  // namespace slipd::feed_ros2
