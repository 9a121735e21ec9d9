// A line for each gripper of a fleet, from the retained topics of its slipd-mqtt (messages.schema.json).
// Pure: it has no connection and no clock. One thread's own.
//
// A gripper's margin is a number only while it is online, its summary is not too old, and each of its sensors
// and grasps has a margin or no contact. Everything that is not known is null.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace slipd::mqtt {

// A time on both clocks.
struct Moment {
  std::chrono::steady_clock::time_point steady;
  // CLOCK_REALTIME, which is compared with that of grippers, for messages that a broker kept.
  std::int64_t realtime_ns = 0;
};

class Fleet {
 public:
  // Grippers, and sensors and grasps of one, beyond which further ones are left out.
  static constexpr std::size_t kMostGrippers = 100'000, kMostNames = 1000;

  // `prefix`: topic_prefix of the grippers.
  explicit Fleet(std::string prefix);

  // What to subscribe to.
  std::vector<std::string> filters() const;

  // A message of one of these topics. Returns the gripper that it is of; empty: it is none of slipd-mqtt's.
  // An empty payload removes what the topic said, and with status, summary and seen the gripper.
  std::string take(std::string_view topic, std::string_view payload, bool retained, const Moment& now);

  // In the order of their names.
  std::vector<std::string> grippers() const;

  // The line as JSON text: gripper, status (online, offline, unknown; removed: there is no such gripper
  // anymore), state (the worst one) and state_of (the sensor or grasp that has it), gamma (least margin of
  // the last summary's period) and gamma_of, alert (the worst that stands; unknown where nobody watches),
  // alerts_last_hour, alerts_waiting, alerts_dropped, version (of slipd), simulated, offline_since_ns
  // (CLOCK_REALTIME of the last sign of life).
  std::string line(const std::string& gripper, const Moment& now) const;

  // The broker is away: nothing is known.
  void clear() { grippers_.clear(); }

 private:
  using Json = nlohmann::ordered_json;
  struct Gripper {
    // Payloads; null: there was none.
    Json status, summary, seen;
    // Of each sensor and grasp by its name.
    std::map<std::string, Json> states;
    // When the summary was made.
    std::chrono::steady_clock::time_point made;
  };
  // The sensor or grasp that is worst off.
  struct Worst {
    std::string state;
    Json name;
    bool all_known = true;
  };
  static bool online(const Gripper& gripper);
  static bool is_fresh(const Gripper& gripper, const Moment& now);
  static Worst worst_of(const Gripper& gripper);
  static const char* worst_alert_of(const Gripper& gripper, bool watched);
  static void add_margin(const Gripper& gripper, Json& line);
  static void add_counts(const Gripper& gripper, bool fresh, Json& line);

  std::string prefix_;
  std::map<std::string, Gripper, std::less<>> grippers_;
};

}  // namespace slipd::mqtt
