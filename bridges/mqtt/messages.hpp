// What slipd-mqtt publishes, as JSON text (messages.schema.json). Pure. Any one thread.
#pragma once

#include <slipd.h>

#include <chrono>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bridges/support/inventory.hpp"

namespace slipd::mqtt {

// What is known of the alerts of this gripper.
struct AlertCounts {
  // Random name of the store. Numbers of one series are never used twice.
  std::string series;
  // Number of the last alert, from 1; 0: there was none.
  std::int64_t last = 0;
  // Alerts that no broker has acknowledged.
  std::int64_t waiting = 0;
  // Alerts of this series that a full or failing store dropped.
  std::int64_t dropped = 0;
};

// An estimate as slipd sent it, with the state and alert of `estimate`. If that is too old by now, state is
// "stale" and margin and advice are null. Empty if `text` is no JSON object.
std::string estimate_message(const slipd_estimate& estimate, std::string_view text);

// State, health and alert of a sensor or grasp. `text`: what slipd sent, GraspEstimate::text or away_text().
// `valid_for`: how long it holds unless another one comes.
std::string state_message(const slipd_estimate& estimate, std::string_view text,
                          std::chrono::milliseconds valid_for);
// In place of what slipd sent while it is away.
std::string away_text(const std::string& sensor, std::int64_t now_ns);
std::string away_text(const bridges::GraspFacts& grasp, std::int64_t now_ns);

// What is left of an estimate that is too old: no margin, and of its alert what still stands.
void grow_old(slipd_estimate& estimate);

// A grasp as an estimate for the functions here.
struct GraspEstimate {
  // name, state, alert, gamma, age_s and valid_until_ns; state is "stale" if the oldest of its sensors is too
  // old.
  slipd_estimate estimate{};
  // slipd's object, with time_ns and age_ms of the oldest of its sensors, and simulated if one of them is.
  std::string text;
};
// The grasps of slipd's answer to `gamma`. `monotonic_ns`: CLOCK_MONOTONIC when it came. Empty for a text
// that is no such answer.
std::vector<GraspEstimate> grasps_of(std::string_view answer, double max_age_s, std::int64_t monotonic_ns);

// An alert: a record of the sample's moment. `number` is that of the alert, `dropped` as in AlertCounts.
std::string alert_message(std::string_view text, const std::string& series, std::int64_t number,
                          std::int64_t dropped);

// What a status and a summary are made of.
struct Gripper {
  // Version of slipd-mqtt.
  std::string version;
  // None: slipd is away.
  std::optional<bridges::Inventory> slipd;
  AlertCounts alerts;
  // Why slipd is away; empty if it is not.
  std::string trouble;
  // How long what is said of it holds unless it is said again.
  std::chrono::milliseconds valid_for{};
};

// Birth and every change: online, versions, sensors, grasps, and a hash of these.
std::string online_message(const Gripper& gripper, std::int64_t now_ns);
// Last will, and at an orderly end. `now_ns` 0: unknown, as of a last will.
std::string offline_message(std::int64_t now_ns);
// Last sign of life: time and version of slipd. It stays when all else of a gripper has expired.
std::string seen_message(const Gripper& gripper, std::int64_t now_ns);

// Latest state and margin of a sensor or grasp for the summary.
struct SummaryLine {
  std::string state = "stale";
  std::string alert = "unknown";
  // NaN unless state is ok and the estimate young.
  double gamma = std::numeric_limits<double>::quiet_NaN();
  // The least margin since the summary before; NaN: there was none.
  double gamma_min = std::numeric_limits<double>::quiet_NaN();
};
struct Summary {
  // By name.
  std::map<std::string, SummaryLine> sensors, grasps;
  // None: unknown.
  std::optional<std::int64_t> alerts_last_hour;
  // The next summary comes in this time or earlier, s.
  double period_s = 0;
};
// Retained, once a period and soon after an alert: time, sensors, grasps, alerts of the last hour.
std::string summary_message(const Gripper& gripper, const Summary& summary, std::int64_t now_ns);

// Same for grippers with the same sensors and grasps: 16 hexadecimal digits.
std::string inventory_hash(const bridges::Inventory& inventory);

}  // namespace slipd::mqtt
