// A CAN interface of which a test says how it fares; what was sent is decoded by the shipped DBC.
#pragma once

#include <cerrno>
#include <deque>
#include <string>
#include <vector>

#include "daemon/can/port.hpp"
#include "embedded/slipd_dbc.hpp"
#include "tests/support/dbc.hpp"

namespace slipd::can {

class FakePort : public Port {
 public:
  int open() noexcept override {
    ++opened;
    return open_error;
  }
  void close() noexcept override {}
  int send(const Message& message) noexcept override {
    ++attempts;
    if (send_error != 0) return send_error;
    if (room == 0) return ENOBUFS;
    --room;
    sent.push_back(message);
    return 0;
  }
  bool next_error(BusError& error) noexcept override {
    if (errors.empty()) return false;
    error = errors.front();
    errors.pop_front();
    return true;
  }

  // What was sent since the last call with this identifier.
  std::vector<Message> take(std::uint32_t id) {
    std::vector<Message> found;
    for (const Message& each : sent) {
      if (each.id == id) found.push_back(each);
    }
    std::erase_if(sent, [id](const Message& each) { return each.id == id; });
    return found;
  }

  int open_error = 0, send_error = 0;
  std::size_t room = 1000000;
  int opened = 0, attempts = 0;
  std::vector<Message> sent;
  std::deque<BusError> errors;
};

// Of a message of the default base_id.
inline std::uint64_t raw(const Message& message, const char* signal) {
  static const auto messages = testing::read_dbc(std::string(slipd_dbc));
  const std::uint32_t shipped = message.id >= 0x5E0   ? 0x5E0
                                : message.id == 0x5DF ? 0x5DF
                                : message.id < 0x5C0  ? 0x5A0
                                                      : 0x5C0;
  return messages.at(shipped).signals.at(signal).raw(message.data);
}

}  // namespace slipd::can
