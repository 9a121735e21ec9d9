// slipd-mqtt's settings. Called from main.
#pragma once

#include <chrono>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "schema/schema.hpp"

namespace slipd::mqtt {

struct TlsSettings {
  // Trusted authorities, PEM.
  std::string ca_file;
  // Own certificate and its key, PEM; empty: none.
  std::string cert_file, key_file;
};

struct BrokerSettings {
  // Name or address.
  std::string host;
  // TCP port.
  int port = 1883;
  // Empty: none.
  std::string user;
  // Path, credentials resolved; empty: no password.
  std::string password_file;
  // None: no encryption.
  std::optional<TlsSettings> tls;
  // Longest silence of the broker.
  std::chrono::seconds keepalive{15};

  // "host:port", for people.
  std::string name() const { return host + ":" + std::to_string(port); }
};

struct Settings {
  std::vector<BrokerSettings> brokers;
  // This gripper in topics.
  std::string host;
  std::string topic_prefix;
  // Highest rate of estimates of a sensor, Hz.
  double rate_hz = 10;
  // Older estimates have no margin, s.
  double max_age_s = 0.5;
  // Period of the summary.
  std::chrono::milliseconds summary{10'000};
  // slipd's socket.
  std::string socket;
  // Database of alerts.
  std::filesystem::path store;
  // Most alerts in it.
  std::int64_t max_alerts = 10'000;
};

// From settings that fit mqtt.schema.json.
Settings settings_of(const nlohmann::json& checked);

// Rules that the schema cannot state: a key needs its certificate, and a password is not sent in the clear to
// another host.
std::vector<Problem> further_problems(const nlohmann::json& checked);

}  // namespace slipd::mqtt
