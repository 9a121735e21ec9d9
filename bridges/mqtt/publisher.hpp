// slipd-mqtt itself: slipd's estimates to topics of one broker at a time. One thread's own: that of the loop.
//
// slipd's socket has events of sensors only. Grasps are asked for after estimates and events of their
// sensors, and their alerts are found by comparing: one that begins and ends between two answers is missed.
//
// Estimates, states, status and summary have one place each, in which the newest replaces what was not sent
// yet: a slow or absent broker costs no memory, and no estimate waits for longer than it holds. All retained
// topics are said again once a period and expire after two, so that none outlives this program. Alerts go
// through the store on disk and stay there until a broker has acknowledged them; at most kWindow of them are
// on their way, in the order of their numbers.
#pragma once

#include <map>
#include <memory>
#include <random>
#include <string>

#include "bridges/mqtt/alert_store.hpp"
#include "bridges/mqtt/broker.hpp"
#include "bridges/mqtt/broker_turns.hpp"
#include "bridges/mqtt/messages.hpp"
#include "bridges/mqtt/settings.hpp"
#include "bridges/mqtt/states.hpp"
#include "bridges/mqtt/tried_broker.hpp"
#include "bridges/support/feed.hpp"
#include "bridges/support/program.hpp"

namespace slipd::mqtt {

class Publisher : public bridges::Service {
 public:
  // Alerts on their way without an acknowledgement. More fill a fast link better; all are sent again after a
  // loss.
  static constexpr std::size_t kWindow = 16;

  // Throws std::runtime_error if the store cannot be used.
  Publisher(Settings settings, std::string version, bridges::Loop& loop);
  // Publishes that nobody watches and that it is offline.
  ~Publisher() override;

 private:
  // The newest message of one topic that was not sent yet.
  struct Pending {
    std::string payload;
    bool retain = false;
    std::chrono::steady_clock::time_point expires = std::chrono::steady_clock::time_point::max();
    // For the broker; 0: none.
    std::chrono::seconds broker_keeps{0};
  };

  bridges::FeedListener feed_listener();
  bridges::FeedOptions feed_options() const;
  std::chrono::nanoseconds silence() const;
  double feed_rate_hz() const;
  double patience_s() const;
  void take(const slipd_estimate& estimate, std::string_view text);
  // `stood`: the alert that stood until now.
  void take_alert(const slipd_estimate& estimate, int stood, std::string_view text);
  void want_grasps(const slipd_estimate& estimate);
  void ask_grasps();
  void take_grasp(const GraspEstimate& grasp);
  void note_margin(const slipd_estimate& estimate);
  void put_estimate(const slipd_estimate& estimate, std::string_view text);
  bool serves(const std::string& name) const;
  void note_serving(const bridges::Inventory& inventory);
  void note_away(std::string_view why);
  void lose_states();
  void say_states();

  std::size_t first_broker() const;
  void connect();
  void note_accepted();
  void note_acknowledged(int message);
  void note_lost(const std::string& why);
  void check_progress();

  void put(const std::string& topic, Pending message);
  void put_retained(const std::string& topic, std::string payload);
  std::chrono::milliseconds valid_for() const { return 2 * settings_.summary; }
  void put_status();
  void put_summary();
  void send();
  void send_alerts();
  std::string topic_of(const std::string& sensor, const char* kind) const;
  std::string host_topic(const char* kind) const;
  Gripper gripper() const;
  SummaryLine summary_line(const slipd_estimate& estimate) const;

  Settings settings_;
  std::string version_;
  bridges::Loop& loop_;
  AlertStore store_;
  TriedBroker tried_;
  BrokerTurns turns_;
  std::minstd_rand random_;

  // What is known of slipd.
  std::optional<bridges::Inventory> slipd_;
  std::string trouble_{"not asked yet"};
  States states_;                        // of each sensor and grasp
  std::map<std::string, double> least_;  // their least margin since the last summary
  std::map<std::string, std::chrono::steady_clock::time_point> estimate_due_;  // next estimate of each
  bool want_grasp_estimates_ = false;                                          // not only their changes
  std::chrono::steady_clock::time_point grasps_asked_at_{};                    // last request
  bool summary_is_near_ = false;                                               // because of an alert

  // What waits for the broker, by topic.
  std::map<std::string, Pending> pending_;
  std::map<int, std::int64_t> on_their_way_;           // number of libmosquitto → of the alert
  std::int64_t sent_ = 0;                              // number of the last alert given to this connection
  std::chrono::steady_clock::time_point progress_at_;  // last acknowledgement, or when the window was empty
  std::int64_t told_dropped_ = 0;

  MosquittoLibrary library_;
  MqttVersion mqtt_ = MqttVersion::v5;  // of the next attempt
  std::unique_ptr<Broker> broker_;
  bridges::Loop::Timer connecting_, summary_, flush_, asking_, saying_;
  bridges::Feed feed_;
};

}  // namespace slipd::mqtt
