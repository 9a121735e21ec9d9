// A connection to slipd's socket: lines out, lines in, descriptors both ways. One thread's own. Functions
// throw Failure or std::bad_alloc.
#pragma once

#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

#include "core/storage/unique_fd.hpp"

namespace slipd::client {

using Clock = std::chrono::steady_clock;

// What a function of slipd.h returns instead of a result.
class Failure : public std::runtime_error {
 public:
  Failure(int code, const std::string& text) : std::runtime_error(text), code_(code) {}
  // SLIPD_DISCONNECTED, …
  int code() const noexcept { return code_; }

 private:
  int code_;
};

class Connection {
 public:
  bool connected() const noexcept { return static_cast<bool>(socket_); }
  int fd() const noexcept { return socket_.get(); }

  // Connects, unless it is connected.
  void connect(const std::string& path);
  void close() noexcept;

  // Sends a request; `descriptor` -1: none. Returns its id.
  std::uint64_t request(std::string_view method, std::string_view params, int descriptor,
                        Clock::time_point until);
  // The next line that has arrived by `until`, without its end. False: none. The line is valid until the next
  // call.
  bool line(std::string_view& text, Clock::time_point until);
  // The answer to a request, as the JSON text of the result. Throws away other lines.
  std::string answer(std::uint64_t id, Clock::time_point until);
  // The descriptor that came last.
  UniqueFd take_descriptor() noexcept { return std::move(passed_); }

 private:
  bool wait_for(short events, Clock::time_point until) const;
  bool receive(Clock::time_point until);

  UniqueFd socket_;
  UniqueFd passed_;
  std::string input_;
  std::size_t begin_ = 0;  // of what is not yet handed out
  std::uint64_t last_id_ = 0;
};

}  // namespace slipd::client
