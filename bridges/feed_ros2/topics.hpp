// slipd-feed-ros2 itself: a node that subscribes to the topics of all sensors, a lane for each, and the log.
// Topics are read in one thread, frames go to slipd in one for each sensor, and the loop's thread tells.
#pragma once

#include <dds/dds.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "bridges/feed_lane/lane.hpp"
#include "bridges/feed_lane/teller.hpp"
#include "bridges/feed_ros2/settings.hpp"
#include "bridges/feed_ros2/topic.hpp"
#include "bridges/ros2/dds/cyclone_log.hpp"
#include "bridges/ros2/dds/host_watch.hpp"
#include "bridges/ros2/dds/node.hpp"
#include "bridges/ros2/dds/subscription.hpp"
#include "bridges/support/program.hpp"

namespace slipd::feed_ros2 {

class Topics : public bridges::Service {
 public:
  // Throws ros2::DdsError, client::Error.
  Topics(const Settings& settings, bridges::Loop& loop);
  ~Topics() override;

 private:
  bool refuse(std::string_view topic);
  void read();

  std::vector<std::unique_ptr<feed::Lane>> lanes_;
  feed::Teller teller_;
  std::multimap<std::string, feed::Lane*, std::less<>> lanes_of_;  // by topic
  ros2::CycloneLog cyclone_;
  ros2::Node node_;
  ros2::HostWatch host_;
  ros2::Publications publications_;
  std::vector<std::unique_ptr<Topic>> topics_;
  dds_entity_t ending_, waiting_;
  std::thread reader_;
};

}  // namespace slipd::feed_ros2
