// A network interface through a raw SocketCAN socket.
#pragma once

#include <cstddef>

#include "config/settings.hpp"
#include "daemon/can/port.hpp"

namespace slipd::can {

// Not thread-safe. Called from one thread: can; constructed and destroyed by io.
class SocketPort : public Port {
 public:
  // `messages`: in one period. The socket's buffer holds little more, so that a bus that was down for a while
  // does not get outdated messages. `settings` outlives it.
  SocketPort(const CanSettings& settings, std::size_t messages) : settings_(settings), messages_(messages) {}
  ~SocketPort() override { SocketPort::close(); }
  SocketPort(const SocketPort&) = delete;
  SocketPort& operator=(const SocketPort&) = delete;

  int open() noexcept override;
  void close() noexcept override;
  int send(const Message& message) noexcept override;
  bool next_error(BusError& error) noexcept override;

 private:
  int set_up() noexcept;

  const CanSettings& settings_;
  std::size_t messages_;
  int fd_ = -1;
};

}  // namespace slipd::can
