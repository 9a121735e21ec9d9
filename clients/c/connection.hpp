// A connection to slipd's socket: messages out, messages and descriptors in. libslipd and slipctl are
// built on it. One thread's own. Functions throw Failure or std::bad_alloc.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>

#include "core/storage/unique_fd.hpp"

namespace slipd::client {

using Clock = std::chrono::steady_clock;
// Keys in the order in which slipd sends them.
using Json = nlohmann::ordered_json;

// What a function of slipd.h returns instead of a result. what() states the remedy.
class Failure : public std::runtime_error {
 public:
  Failure(int code, const std::string& text, int rpc_code = 0)
      : std::runtime_error(text), code_(code), rpc_code_(rpc_code) {}
  // SLIPD_DISCONNECTED, …
  int code() const noexcept { return code_; }
  // Of SLIPD_REFUSED: the error's code, docs/socket.md. Otherwise 0.
  int rpc_code() const noexcept { return rpc_code_; }

 private:
  int code_;
  int rpc_code_;
};

// Throws the error of a message that has one: SLIPD_REFUSED if `ours`, else SLIPD_DISCONNECTED, because slipd
// sends errors without a request before it closes the connection.
void throw_error_of(const Json& message, bool ours);

// A line as a JSON object.
Json message_of(std::string_view line);

class Connection {
 public:
  bool connected() const noexcept { return static_cast<bool>(socket_); }
  int fd() const noexcept { return socket_.get(); }

  // Connects, unless it is connected.
  void connect(const std::string& path);
  void close() noexcept;

  // Sends a request; `params`: JSON text. Returns its id.
  std::uint64_t request(std::string_view method, std::string_view params, Clock::time_point until);
  // The next message that has arrived by `until`, unread; valid until the next call of a function. False:
  // none.
  bool line(std::string_view& out, Clock::time_point until);
  // The same, read: a JSON object.
  bool message(Json& out, Clock::time_point until);
  // The result of a request. Messages before it go to `other`, or are thrown away.
  Json answer(std::uint64_t id, Clock::time_point until, const std::function<void(Json&&)>& other = {});
  // The descriptor that came last.
  UniqueFd take_descriptor() noexcept { return std::move(passed_); }

 private:
  bool wait_for(short events, Clock::time_point until) const;
  bool receive(Clock::time_point until);

  UniqueFd socket_;
  UniqueFd passed_;
  std::string piece_;  // of one read, kept because filling new memory takes longer than the read
  std::string input_;
  std::size_t begin_ = 0;     // of what is not yet handed out
  std::size_t searched_ = 0;  // from begin_ to here there is no end of line
  std::uint64_t last_id_ = 0;
};

}  // namespace slipd::client
