#include "bridges/mqtt/settings.hpp"

#include <unistd.h>

#include <array>
#include <cstdlib>
#include <nlohmann/json.hpp>

namespace slipd::mqtt {
namespace {

using nlohmann::json;

constexpr int kPort = 1883, kTlsPort = 8883;

// A name without a slash is a file in systemd's folder of credentials.
std::string resolved(const std::string& file) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): no thread changes the environment
  const char* const credentials = std::getenv("CREDENTIALS_DIRECTORY");
  if (file.empty() || file.find('/') != std::string::npos || credentials == nullptr) return file;
  return (std::filesystem::path(credentials) / file).string();
}

std::string host_name() {
  constexpr std::size_t kLongest = 65;
  std::array<char, kLongest> name{};
  if (gethostname(name.data(), name.size() - 1) != 0 || name.front() == 0) return "localhost";
  return name.data();
}

bool on_loopback(const std::string& host) {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}

BrokerSettings broker_of(const json& object) {
  BrokerSettings broker;
  broker.host = object.at("host");
  broker.user = object.value("user", "");
  broker.password_file = resolved(object.value("password_file", ""));
  broker.keepalive = std::chrono::seconds(object.at("keepalive_s").get<int>());
  if (const auto tls = object.find("tls"); tls != object.end()) {
    broker.tls = {tls->at("ca_file"), tls->value("cert_file", ""), resolved(tls->value("key_file", ""))};
  }
  broker.port = object.value("port", broker.tls ? kTlsPort : kPort);
  return broker;
}

}  // namespace

Settings settings_of(const json& checked) {
  Settings settings;
  for (const json& broker : checked.at("brokers")) settings.brokers.push_back(broker_of(broker));
  settings.host = checked.contains("host") ? checked["host"].get<std::string>() : host_name();
  settings.topic_prefix = checked.at("topic_prefix");
  settings.rate_hz = checked.at("rate_hz");
  settings.max_age_s = checked.at("max_age_ms").get<double>() / 1e3;
  settings.summary = std::chrono::milliseconds(static_cast<int>(1e3 * checked.at("summary_s").get<double>()));
  settings.socket = checked.at("socket");
  settings.store = checked.at("store").at("file").get<std::string>();
  settings.max_alerts = checked.at("store").at("max_alerts");
  return settings;
}

std::vector<Problem> further_problems(const json& checked) {
  std::vector<Problem> problems;
  const json& brokers = checked.at("brokers");
  for (std::size_t i = 0; i < brokers.size(); ++i) {
    const json& broker = brokers[i];
    const std::string at = pointer_to("/brokers", i);
    const auto tls = broker.find("tls");
    if (tls != broker.end() && tls->contains("cert_file") != tls->contains("key_file"))
      problems.push_back(problem_of(at + "/tls", *tls, "needs both cert_file and key_file, or neither"));
    if (broker.contains("password_file") && !broker.contains("user"))
      problems.push_back(problem_of(at + "/password_file", broker["password_file"], "needs user as well"));
    if (broker.contains("password_file") && tls == broker.end() && !on_loopback(broker.at("host")))
      problems.push_back(problem_of(at + "/password_file", broker["password_file"],
                                    "would be sent in the clear to another host; add tls"));
  }
  return problems;
}

}  // namespace slipd::mqtt
