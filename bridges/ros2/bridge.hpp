// slipd-ros2's service: slipd's estimates as they come, published on ROS 2 topics. The loop's thread, but for
// taxels, and for what is published while estimates fail to come (subjects.hpp).
//
// Messages are made for topics that have a reader, or for a recording. While there is neither, slipd is asked
// for a few estimates a second only.
#pragma once

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bridges/ros2/dds/host_watch.hpp"
#include "bridges/ros2/dds/node.hpp"
#include "bridges/ros2/output.hpp"
#include "bridges/ros2/recorder.hpp"
#include "bridges/ros2/subjects.hpp"
#include "bridges/ros2/taxel_lane.hpp"
#include "bridges/support/bell.hpp"
#include "bridges/support/feed.hpp"
#include "bridges/support/loop.hpp"
#include "bridges/support/program.hpp"

namespace slipd::ros2 {

class Ros2Bridge final : public bridges::Service {
 public:
  // `settings` fit the schema. Throws DdsError, McapError.
  Ros2Bridge(const nlohmann::json& settings, bridges::Loop& loop);

 private:
  TopicOptions topic_options(const char* topic) const;
  void serve(const bridges::Inventory& inventory);
  void open_topics(const bridges::Inventory& inventory);
  void add_subject(const std::string& name, const std::string& hardware, std::vector<TaxelSource>* taxels);
  void attach();
  void go_away(std::string_view why);
  void choose_rate();
  void take(const slipd_estimate& estimate);
  void report();

  nlohmann::json settings_;
  double max_age_s_;
  Recorder recorder_;
  bridges::Bell readers_changed_;  // Cyclone's threads ring it
  Node node_;
  std::optional<Output<DiagnosticArray>> diagnostics_;
  Subjects subjects_;
  bridges::Inventory served_;
  std::map<std::string, std::vector<std::string>, std::less<>>
      grasps_;  // to read when a sensor's estimate comes
  std::unique_ptr<TaxelLane> taxels_;
  bool attached_ = false;
  std::int64_t reported_ns_ = 0;
  bridges::Loop::Timer report_;
  bridges::Feed feed_;
  bridges::Loop::Watch readers_;
  HostWatch host_;
};

}  // namespace slipd::ros2
