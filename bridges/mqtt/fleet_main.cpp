// slipd-fleet: the grippers of a broker as JSON lines, for `slipctl fleet`, which shows them. It is a program
// of its own so that slipctl does not need libmosquitto.
//
// A line for each gripper, then one for each change (fleet.hpp); a line {"broker", "connected", "trouble"}
// when the broker comes or goes, after which earlier state is discarded.
#include <sys/epoll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <system_error>

#include "bridges/mqtt/broker.hpp"
#include "bridges/mqtt/broker_turns.hpp"
#include "bridges/mqtt/fleet.hpp"
#include "bridges/mqtt/settings.hpp"
#include "bridges/support/clock.hpp"
#include "bridges/support/loop.hpp"
#include "bridges/support/settings_file.hpp"
#include "embedded/slipd_mqtt_schema.hpp"
#include "schema/settings_error.hpp"

namespace slipd::mqtt {
namespace {

using nlohmann::json;

constexpr int kFailed = 1, kWrongUse = 2;
// How often lines are judged anew, because summaries age.
constexpr std::chrono::seconds kJudgePeriod{1};
// After the last retained message until the lines are complete.
constexpr std::chrono::milliseconds kQuiet{300};
// --once: for the broker to accept and to send all that it keeps.
constexpr std::chrono::seconds kOncePatience{20};
constexpr TurnOptions kTurns{std::chrono::milliseconds(500), std::chrono::milliseconds(5000),
                             std::chrono::milliseconds(10'000)};

struct Options {
  Settings settings;
  bool once = false;
};

Moment now() {
  return {std::chrono::steady_clock::now(), bridges::realtime_ns()};
}

class FleetProgram {
 public:
  FleetProgram(const Options& options, bridges::Loop& loop)
      : options_(options),
        loop_(loop),
        fleet_(options.settings.topic_prefix),
        turns_(options.settings.brokers.size(), kTurns),
        random_(std::random_device{}()),
        connecting_(loop, [this] { connect(); }),
        judging_(loop, [this] { judge_all(); }),
        quiet_(loop, [this] { complete(); }),
        patience_(loop, [this] { give_up(name_ + ": does not send in time what it keeps"); }) {
    connecting_.start({});
    if (options_.once) patience_.start(kOncePatience);
    // A reader that has gone is seen at once, not with the next line. A file cannot be watched.
    try {
      reader_ = bridges::Loop::Watch(loop, STDOUT_FILENO, 0, [this](std::uint32_t) { loop_.stop(); });
    } catch (const std::system_error&) {
    }
  }

  int exit_code() const { return exit_code_; }

 private:
  void connect() {
    const BrokerSettings& broker = options_.settings.brokers[turns_.current()];
    name_ = broker.name();
    BrokerListener listener;
    listener.accepted = [this] { broker_->subscribe(fleet_.filters()); };
    listener.message = [this](std::string_view topic, std::string_view payload, bool retained) {
      take(topic, payload, retained);
    };
    listener.subscribed = [this] {
      answered_ = true;
      quiet_.start(kQuiet);
    };
    listener.lost = [this](const std::string& why) { lose(why); };
    const std::string id = "slipd-fleet-" + std::to_string(getpid()) + "-" + std::to_string(random_());
    broker_ = std::make_unique<Broker>(loop_, broker, id, MqttVersion::v3_1_1, std::nullopt, listener);
  }

  void take(std::string_view topic, std::string_view payload, bool retained) {
    const std::string gripper = fleet_.take(topic, payload, retained, now());
    if (answered_ && !complete_) quiet_.start(kQuiet);
    if (complete_ && !gripper.empty()) show(gripper);
  }

  // What the broker kept is here.
  void complete() {
    complete_ = true;
    if (!options_.once) print(json{{"broker", name_}, {"connected", true}, {"trouble", nullptr}}.dump());
    judge_all();
    if (options_.once) loop_.stop();
  }

  void judge_all() {
    if (!complete_) return;
    for (const std::string& gripper : fleet_.grippers()) show(gripper);
    judging_.start(kJudgePeriod);
  }

  // Prints the gripper's line if it is another one than before.
  void show(const std::string& gripper) {
    std::string line = fleet_.line(gripper, now());
    std::string& shown = shown_[gripper];
    if (line == shown) return;
    print(line);
    shown = std::move(line);
  }

  void lose(const std::string& why) {
    if (options_.once) return give_up(why);
    if (complete_ || why != trouble_)
      print(json{{"broker", name_}, {"connected", false}, {"trouble", why}}.dump());
    trouble_ = why;
    const auto held = broker_->held();
    broker_.reset();
    fleet_.clear();
    shown_.clear();
    complete_ = answered_ = false;
    quiet_.stop();
    judging_.stop();
    const double share = static_cast<double>(random_()) / static_cast<double>(std::minstd_rand::max());
    connecting_.start(turns_.lost(held, share));
  }

  void give_up(const std::string& why) {
    std::fprintf(stderr, "slipctl fleet: %s\n", why.c_str());
    exit_code_ = kFailed;
    loop_.stop();
  }

  void print(const std::string& line) {
    if (std::printf("%s\n", line.c_str()) < 0 || std::fflush(stdout) != 0) loop_.stop();
  }

  Options options_;
  bridges::Loop& loop_;
  MosquittoLibrary library_;
  Fleet fleet_;
  BrokerTurns turns_;
  std::minstd_rand random_;
  std::map<std::string, std::string> shown_;  // last line of each gripper
  std::string name_, trouble_;
  bool answered_ = false, complete_ = false;
  int exit_code_ = 0;
  std::unique_ptr<Broker> broker_;
  bridges::Loop::Timer connecting_, judging_, quiet_, patience_;
  bridges::Loop::Watch reader_;
};

// HOST, HOST:PORT, [IPV6]:PORT or IPV6.
json broker_of(const std::string& text) {
  const auto bracket = text.starts_with('[') ? text.find(']') : std::string::npos;
  const bool bare = bracket == std::string::npos && std::count(text.begin(), text.end(), ':') > 1;
  const auto colon = bare ? std::string::npos : text.find(':', bracket == std::string::npos ? 0 : bracket);
  const std::string host = text.substr(0, colon);
  json broker{{"host", bracket == std::string::npos ? host : text.substr(1, bracket - 1)}};
  if (colon == std::string::npos) return broker;
  const std::string port = text.substr(colon + 1);
  const bool number =
      !port.empty() && port.size() < 6 && port.find_first_not_of("0123456789") == std::string::npos;
  broker["port"] = number ? json(std::stoi(port)) : json(port);
  return broker;
}

// The command line as settings of slipd-mqtt, so that the same rules hold. An exit code if it is wrong or
// asks for help; negative: go on.
int parse(int argc, char** argv, Options& out) {
  CLI::App app{"The grippers of an MQTT broker as JSON lines; slipctl(1) shows them", "slipd-fleet"};
  std::string broker = "localhost", prefix = "slipd", user, password, ca, certificate, key;
  bool tls = false;
  app.add_option("--broker", broker, "HOST[:PORT]");
  app.add_option("--prefix", prefix, "what the topics begin with");
  app.add_option("--user", user, "user name at the broker");
  app.add_option("--password-file", password, "file with the password in its first line");
  app.add_flag("--tls", tls, "TLS 1.2 or newer");
  app.add_option("--ca-file", ca, "trusted authorities, PEM; with it TLS is used");
  app.add_option("--cert-file", certificate, "own certificate, PEM");
  app.add_option("--key-file", key, "its key, PEM");
  app.add_flag("--once", out.once, "print the present lines and end");
  app.set_version_flag("--version", "slipd-fleet " SLIPD_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kWrongUse;
  }
  json settings = broker_of(broker);
  if (!user.empty()) settings["user"] = user;
  if (!password.empty()) settings["password_file"] = password;
  if (tls || !ca.empty() || !certificate.empty() || !key.empty()) settings["tls"] = json::object();
  if (!ca.empty()) settings["tls"]["ca_file"] = ca;
  if (!certificate.empty()) settings["tls"]["cert_file"] = certificate;
  if (!key.empty()) settings["tls"]["key_file"] = key;
  const json all{{"brokers", {std::move(settings)}}, {"topic_prefix", prefix}};
  out.settings = settings_of(
      bridges::parse_settings(all.dump(), "the command line", slipd_mqtt_schema, further_problems));
  return -1;
}

int run(int argc, char** argv) {
  Options options;
  if (const int code = parse(argc, argv, options); code >= 0) return code;
  std::signal(SIGPIPE, SIG_IGN);  // a reader that goes is an error of write()
  bridges::Loop loop;
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) loop.on_signal(number, [&] { loop.stop(); });
  FleetProgram program(options, loop);
  loop.run();
  return program.exit_code();
}

}  // namespace
}  // namespace slipd::mqtt

int main(int argc, char** argv) {
  try {
    return slipd::mqtt::run(argc, argv);
  } catch (const slipd::SettingsError& error) {
    for (const std::string& problem : error.problems())
      std::fprintf(stderr, "slipctl fleet: %s\n", problem.c_str());
    return slipd::mqtt::kWrongUse;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "slipctl fleet: %s\n", error.what());
    return slipd::mqtt::kFailed;
  }
}
