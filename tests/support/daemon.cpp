#include "tests/support/daemon.hpp"

#include <gtest/gtest.h>
#include <signal.h>

#include <thread>

#include "tests/support/notify_socket.hpp"
#include "tests/support/process_facts.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

// The deadline of a wait.
class Patience {
 public:
  explicit Patience(Program& program) : program_(program) {}

  // Waits a little. Throws when slipd has ended, or has logged nothing for kPatience.
  void hold(const std::string& last_seen) {
    const std::uintmax_t said = program_.errors().size();
    const auto now = std::chrono::steady_clock::now();
    if (said != said_) until_ = now + kPatience;
    said_ = said;
    const auto code = program_.wait(0ms);
    if (code || now > until_) {
      throw std::runtime_error((code ? "slipd has ended with " + std::to_string(*code) : "waited in vain") +
                               "; last: " + last_seen + "; it said: " + program_.errors());
    }
    std::this_thread::sleep_for(5ms);
  }

 private:
  Program& program_;
  std::uintmax_t said_ = 0;
  std::chrono::steady_clock::time_point until_ = std::chrono::steady_clock::now() + kPatience;
};

}  // namespace

std::filesystem::path trial_drivers() {
  return std::filesystem::path(SLIPD_BINARY_DIR) / "test-drivers";
}
std::filesystem::path real_drivers() {
  return std::filesystem::path(SLIPD_BINARY_DIR) / "drivers";
}

json trial_sensor(const std::string& name, const json& options, const json& more) {
  json sensor{{"name", name}, {"driver", "trial"}, {"options", options}};
  sensor.merge_patch(more);
  return sensor;
}

json config_with(const TempFolder& folder, const json& sensors, const json& more) {
  json config{{"sensors", sensors},
              {"socket", {{"path", folder.file("s.sock").string()}}},
              {"estimator", {{"method", "moments"}}},
              {"realtime", {{"mode", "off"}}}};
  config.merge_patch(more);
  return config;
}

Daemon::Daemon(const json& config, const std::filesystem::path& drivers, const Program::Environment& more)
    : socket_(config.at("socket").at("path").get<std::string>()) {
  config_ = folder_.write("slipd.json", config.dump(2));
  const NotifySocket notify(folder_.file("notify"));
  Program::Environment environment = more;
  environment.emplace_back("NOTIFY_SOCKET", folder_.file("notify").string());
  program_ =
      std::make_unique<Program>(folder_, "slipd",
                                std::vector<std::string>{(program_folder() / "slipd").string(), "--config",
                                                         config_.string(), "--driver-dir", drivers.string()},
                                environment);
  Patience patience(*program_);
  while (!notify.says("READY=1", 50ms)) patience.hold("it does not come up");
}

Daemon::~Daemon() {
  const std::string errors = program_->errors();
  EXPECT_EQ(errors.find("Sanitizer"), std::string::npos) << errors;
  EXPECT_EQ(errors.find("runtime error:"), std::string::npos) << errors;
}

json Daemon::wait_for(const std::string& method, const std::function<bool(const json&)>& enough) const {
  RpcClient client(socket_);
  Patience patience(*program_);
  for (;;) {
    json result = client.result(method);
    if (enough(result)) return result;
    patience.hold(result.dump());
  }
}

void Daemon::wait_for_log(const std::string& text) const {
  Patience patience(*program_);
  while (program_->errors().find(text) == std::string::npos) patience.hold("\"" + text + "\" is not said");
}

std::size_t Daemon::descriptors_at_rest() const {
  Patience patience(*program_);
  for (;;) {
    try {
      RpcClient client(socket_);
      while (client.result("status")["clients"] != 1) patience.hold("clients that are gone are not let go");
      // slipd also opens files for a moment: what it holds is there the next time, too.
      const std::size_t held = open_descriptors(program_->pid());
      if (client.result("status")["clients"] == 1 && open_descriptors(program_->pid()) == held) return held;
      patience.hold("descriptors come and go");
    } catch (const RpcClient::NoAnswer&) {  // clients that have left may still hold all places
      patience.hold("clients that are gone keep their places");
    }
  }
}

std::optional<int> Daemon::stop() {
  program_->signal(SIGTERM);
  return program_->wait();
}

}  // namespace slipd::testing
