// The real slipd on a private socket: it serves when the constructor returns.
#pragma once

#include <functional>
#include <memory>

#include "tests/support/program.hpp"
#include "tests/support/rpc_client.hpp"

namespace slipd::testing {

// The folder of the modules for tests (trial), and that of the shipped ones.
std::filesystem::path trial_drivers();
std::filesystem::path real_drivers();

// A sensor of the driver trial, with additional members.
nlohmann::json trial_sensor(const std::string& name, const nlohmann::json& options = nlohmann::json::object(),
                            const nlohmann::json& more = nlohmann::json::object());

// A configuration with these sensors and a socket in the folder, with additional members.
nlohmann::json config_with(const TempFolder& folder, const nlohmann::json& sensors,
                           const nlohmann::json& more = nlohmann::json::object());

// Whether this build runs under a sanitizer. Such a build is slower, and waits a second at its end for late
// reports.
constexpr bool sanitized() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return true;
#else
  return false;
#endif
}

class Daemon {
 public:
  // Starts slipd and waits for READY=1. Throws std::runtime_error with its log if it ends before.
  Daemon(const nlohmann::json& config, const std::filesystem::path& drivers,
         const Program::Environment& more = {});

  // Fails the test if a sanitizer reported an error.
  ~Daemon();

  RpcClient client() const { return RpcClient(socket_); }
  const std::filesystem::path& socket() const { return socket_; }
  const std::filesystem::path& config() const { return config_; }
  Program& program() const { return *program_; }

  // Calls `method` until `enough` accepts the result, and returns that result. Throws when slipd has ended
  // or the time is over. The time begins anew with each line of the log, so a training may take as long as
  // it needs.
  nlohmann::json wait_for(const std::string& method,
                          const std::function<bool(const nlohmann::json&)>& enough) const;

  // The number of open files when there is no client but the one that asks.
  std::size_t descriptors_at_rest() const;

  // Sends SIGTERM and returns the exit code; none if slipd does not end.
  std::optional<int> stop();

  // Waits until the log contains this text, or throws.
  void wait_for_log(const std::string& text) const;

 private:
  TempFolder folder_;
  std::filesystem::path socket_, config_;
  std::unique_ptr<Program> program_;
};

}  // namespace slipd::testing
