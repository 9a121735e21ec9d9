// A CAN bus of two nodes without an interface: a socket pair that transports can_frames.
#pragma once

#include <linux/can.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

#include "daemon/can/port.hpp"

namespace slipd::gripper {

class BusPair final : public can::Port {
 public:
  BusPair() {
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends_.data()) != 0)
      throw std::system_error(errno, std::generic_category(), "socketpair");
  }
  ~BusPair() override {
    for (const int end : ends_) ::close(end);
  }
  BusPair(const BusPair&) = delete;
  BusPair& operator=(const BusPair&) = delete;

  // slipd's end.
  int open() noexcept override { return 0; }
  void close() noexcept override {}
  bool next_error(can::BusError&) noexcept override { return false; }
  int send(const can::Message& message) noexcept override {
    can_frame frame{};
    frame.can_id = message.id;
    frame.len = static_cast<std::uint8_t>(message.data.size());
    std::copy(message.data.begin(), message.data.end(), frame.data);
    return ::send(ends_[0], &frame, sizeof frame, MSG_DONTWAIT | MSG_NOSIGNAL) == sizeof frame ? 0 : errno;
  }

  // The gripper's end: false when no frame is pending.
  bool next(can_frame& frame) const noexcept {
    return ::recv(ends_[1], &frame, sizeof frame, MSG_DONTWAIT) == sizeof frame;
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

}  // namespace slipd::gripper
