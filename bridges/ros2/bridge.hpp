// slipd-ros2's service: slipd's estimates as they come, published on ROS 2 topics. The loop's thread, but for
// taxels.
//
// Fail safe: a margin is a number only in state ok and while it is young. When slipd is away or silent,
// topics get messages without numbers, at once and then once a second, so that a subscriber sees no old
// margin as the last one.
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

#include "bridges/ros2/dds/host_network.hpp"
#include "bridges/ros2/dds/node.hpp"
#include "bridges/ros2/output.hpp"
#include "bridges/ros2/recorder.hpp"
#include "bridges/ros2/taxel_lane.hpp"
#include "bridges/support/bell.hpp"
#include "bridges/support/feed.hpp"
#include "bridges/support/loop.hpp"
#include "bridges/support/program.hpp"

namespace slipd::ros2 {

// Problems of settings that fit the schema: names of `frames`, addresses. For bridges::Program::further.
std::vector<Problem> check_settings(const nlohmann::json& settings);

class Ros2Bridge final : public bridges::Service {
 public:
  // `settings` fit the schema. Throws DdsError, McapError.
  Ros2Bridge(const nlohmann::json& settings, bridges::Loop& loop);

 private:
  // A sensor or grasp.
  struct Subject {
    SlipEstimate last;                      // what was published last
    std::int64_t taken_ns = 0;              // when an estimate came last, CLOCK_MONOTONIC; 0: none has
    std::int64_t published_ns = 0;          // when anything was published last
    std::uint64_t sequence = 0;             // of the estimate that came last
    std::optional<std::uint64_t> reported;  // `sequence` of the last diagnostics
    std::uint64_t dropped = 0;              // estimates that slipd dropped since the start
    std::string hardware;                   // for diagnostics
    std::vector<std::string> grasps;        // to read when this sensor's estimate comes
    std::optional<Output<WrenchStamped>> wrench;
    std::optional<Output<Float32>> margin, margin_low;
    std::optional<Output<SlipEstimate>> estimate, alert;
  };

  TopicOptions topic_options(const char* topic) const;
  void serve(const bridges::Inventory& inventory);
  void add_subject(const std::string& name, const std::string& hardware, bool sensor,
                   std::vector<TaxelSource>& taxels);
  void go_away(std::string_view why);
  bool estimates_wanted() const;
  void choose_rate();
  void note_addresses();
  void take(const slipd_estimate& estimate);
  void take_grasps(const std::vector<std::string>& names);
  void publish(Subject& subject, const Moment& now, bool at_any_rate);
  static void publish_alert(Subject& subject, const SlipEstimate& message, const Moment& now);
  void watch_silence();
  void report();
  static std::string text_of_rate(const Subject& subject, double seconds);
  DiagnosticStatus status_of(const Subject& subject, double seconds) const;

  nlohmann::json settings_;
  double max_age_s_;
  Recorder recorder_;
  bridges::Bell readers_changed_;  // Cyclone's threads ring it
  Node node_;
  std::map<std::string, Subject, std::less<>> subjects_;
  std::optional<Output<DiagnosticArray>> diagnostics_;
  std::unique_ptr<TaxelLane> taxels_;
  bool attached_ = false;
  std::int64_t reported_ns_ = 0;
  bridges::Loop::Timer silence_, report_;
  bridges::Feed feed_;
  bridges::Loop::Watch readers_;
  AddressChanges changes_;
  std::vector<HostInterface> host_;  // after changes_, so that no change is missed
  bridges::Loop::Watch addresses_;
};

}  // namespace slipd::ros2
