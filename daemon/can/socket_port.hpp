// A network interface by raw SocketCAN.
#pragma once

#include <cstddef>

#include "config/settings.hpp"
#include "daemon/can/port.hpp"

namespace slipd::can {

class SocketPort : public Port {
 public:
  // `messages`: of one period. The socket has room for little more, so that a bus that comes back after a
  // while is not told what was true before.
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
