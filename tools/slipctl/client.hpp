// slipctl's side of the socket: libslipd's connection, with errors for a person at a terminal. Each states
// the remedy.
//
// Synchronous; called from one thread. A request waits for its answer; notifications that arrive meanwhile
// are kept in order for next().
#pragma once

#include <chrono>
#include <deque>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "clients/c/connection.hpp"
#include "core/storage/unique_fd.hpp"

namespace slipctl {

using slipd::UniqueFd;

inline constexpr const char* kDefaultSocket = "/run/slipd/slipd.sock";

// No daemon, no permission, a broken connection, a malformed answer.
class ClientError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The daemon answered with an error.
class RpcError : public ClientError {
 public:
  RpcError(int code, const std::string& message) : ClientError(message), code_(code) {}
  int code() const noexcept { return code_; }

 private:
  int code_;
};

struct Notification {
  std::string method;             // "estimate", "alert" …
  nlohmann::ordered_json params;  // as on the socket
};

class RpcClient {
 public:
  // Connects at once. Throws ClientError, which names the socket and the remedy.
  explicit RpcClient(const std::string& socket_path);

  // Sends a request and waits for its result. Throws RpcError for an error answer, ClientError for no answer
  // within `timeout`.
  nlohmann::ordered_json call(const std::string& method,
                              const nlohmann::ordered_json& params = nlohmann::ordered_json::object(),
                              std::chrono::milliseconds timeout = std::chrono::seconds(5));

  // Records a sensor into `file` and returns the daemon's account of it. Throws as call, and ClientError if
  // `file` takes nothing.
  nlohmann::ordered_json record(const std::string& sensor, double seconds, int file);

  // The next notification, or nothing within `timeout` (0: only if one has arrived). Throws ClientError when
  // the daemon has closed the connection.
  std::optional<Notification> next(std::chrono::milliseconds timeout);

  // For poll(): readable when next() can return another notification.
  int fd() const noexcept { return connection_.fd(); }

 private:
  // Calls `body`, which asks for `what`, and turns failures into errors.
  template <typename Body>
  nlohmann::ordered_json asking(const std::string& what, Body body);
  void keep(nlohmann::ordered_json&& message);

  std::string path_;
  slipd::client::Connection connection_;
  std::deque<Notification> waiting_;
};

}  // namespace slipctl
