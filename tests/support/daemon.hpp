// The real slipd on a private socket: ready when the constructor returns.
#pragma once

#include <functional>
#include <memory>

#include "tests/support/program.hpp"
#include "tests/support/rpc_client.hpp"

namespace slipd::testing {

// The folder of the modules that are for tests only (trial), and that of the real ones.
std::filesystem::path trial_drivers();
std::filesystem::path real_drivers();

// A sensor of the driver trial; more members as they are given.
nlohmann::json trial_sensor(const std::string& name, const nlohmann::json& options = nlohmann::json::object(),
                            const nlohmann::json& more = nlohmann::json::object());

// A configuration with these sensors and a socket in the folder; more top-level members as they are given.
nlohmann::json config_with(const TempFolder& folder, const nlohmann::json& sensors,
                           const nlohmann::json& more = nlohmann::json::object());

// Whether this build runs under a sanitizer, which is slower and, at its end, waits a second for late
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
  // Starts it and waits until it says READY=1. Throws std::runtime_error with its errors if it ends before.
  Daemon(const nlohmann::json& config, const std::filesystem::path& drivers,
         const Program::Environment& more = {});

  // Fails the test if a sanitizer had something to say of it.
  ~Daemon();

  RpcClient client() const { return RpcClient(socket_); }
  const std::filesystem::path& socket() const { return socket_; }
  const std::filesystem::path& config() const { return config_; }
  Program& program() const { return *program_; }

  // Asks again and again until `enough` is pleased; the last `method` result. Throws if it never is, or when
  // slipd has ended. Patience begins anew with each line of the log: what makes progress (a training) may
  // take as long as it likes.
  nlohmann::json wait_for(const std::string& method,
                          const std::function<bool(const nlohmann::json&)>& enough) const;

  // How many files it has open once there is no client but the one that asks.
  std::size_t descriptors_at_rest() const;

  // SIGTERM, then its exit code; none if it does not end.
  std::optional<int> stop();

  // Waits until it has said this, or throws.
  void wait_for_log(const std::string& text) const;

 private:
  TempFolder folder_;
  std::filesystem::path socket_, config_;
  std::unique_ptr<Program> program_;
};

}  // namespace slipd::testing
