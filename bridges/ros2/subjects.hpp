// The topics of sensors and grasps: who is published, and what is known of it. A mutex guards all; any
// thread.
//
// Fail safe: a margin is a number only in state ok and while it is young. A thread of its own watches each
// estimate's age and publishes messages without numbers at the moment when it is too old, and again with each
// beat. So they come in time also while the loop waits for a slipd that hangs, and keep the deadline that the
// writers offer.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "bridges/ros2/output.hpp"
#include "bridges/ros2/stamps.hpp"

namespace slipd::ros2 {

// A sensor or grasp.
struct SubjectOptions {
  // In slipd's configuration.
  std::string name;
  // Of the messages' headers.
  std::string frame_id;
  // For diagnostics: the driver, or "grasp".
  std::string hardware;
  // "/slipd"
  std::string prefix;
  // By the last part of a topic's name.
  std::function<TopicOptions(const char* leaf)> topic;
};

class Subjects {
 public:
  // How often messages come while there is no present estimate: ten times a second, or with each max_age_s if
  // that is longer.
  static std::chrono::nanoseconds beat(double max_age_s);

  // `node` and `recorder` must live longer.
  Subjects(Node& node, Recorder& recorder, std::chrono::nanoseconds beat);
  // Publishes that all are disconnected.
  ~Subjects();
  Subjects(const Subjects&) = delete;
  Subjects& operator=(const Subjects&) = delete;

  // False: there is one whose topics have the same names; `other` is set to it. Throws DdsError, McapError.
  bool add(const SubjectOptions& options, std::string& other);
  // Publishes that all are disconnected, and ends their topics.
  void clear();
  // slipd answers, or is away: then all are published as disconnected.
  void set_connected(bool connected);
  // An estimate or an alert. Of a name that is not here: nothing.
  void take(const slipd_estimate& estimate);
  // The stamp of a sample, ns since 1970, which all its messages have.
  std::int64_t stamp_of(std::string_view name, std::uint64_t seq, std::int64_t realtime_ns);
  // Whether a topic that estimates come on by themselves is read or recorded.
  bool wanted() const;
  // Of each, for the `seconds` since the last call.
  std::vector<DiagnosticStatus> diagnostics(double seconds);

 private:
  struct Subject {
    SlipEstimate last;                // what was published last
    std::int64_t fresh_until_ns = 0;  // CLOCK_MONOTONIC until which it holds; 0: there is no present estimate
    std::int64_t published_ns = 0;    // when anything was published last
    std::uint8_t told_state = SlipEstimate::kStale;         // published last
    std::uint8_t told_alert = SlipEstimate::kAlertUnknown;  // published last
    std::uint8_t alert_news = SlipEstimate::kAlertUnknown;  // published last on the topic `alert`
    Stamps stamps;
    std::optional<std::uint64_t> reported;  // `seq` of the last diagnostics
    std::uint64_t dropped = 0;              // estimates that slipd dropped since the start
    std::string hardware;
    std::optional<Output<WrenchStamped>> wrench;
    std::optional<Output<Float32>> margin, margin_low;
    std::optional<Output<SlipEstimate>> estimate, alert;
  };

  static void publish(Subject& subject, const Moment& now);
  static void publish_alert(Subject& subject, const Moment& now);
  void end_estimate(Subject& subject, const Moment& now) const;
  void end_all();
  std::int64_t tend(Subject& subject, const Moment& now) const;
  void watch(const std::stop_token& stop);

  Node& node_;
  Recorder& recorder_;
  const std::int64_t beat_ns_;
  mutable std::mutex mutex_;
  std::map<std::string, Subject, std::less<>> subjects_;
  bool connected_ = false;
  bool sooner_ = false;  // an estimate came that may end before the thread would look
  std::condition_variable_any look_;
  std::jthread watcher_;
};

}  // namespace slipd::ros2
