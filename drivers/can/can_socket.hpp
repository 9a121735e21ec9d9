// A raw SocketCAN socket. The set-up thread opens it; the acquire thread reads it and allocates nothing.
#pragma once

#include <linux/can.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace slipd::can {

// One received CAN frame.
struct ReceivedFrame {
  canfd_frame frame{};       // CAN FD or classic; `len` bytes of its data are valid
  std::int64_t time_ns = 0;  // when the kernel received it from the controller, CLOCK_MONOTONIC
};

enum class ReceiveResult : std::uint8_t { frame, timeout, disconnected };

// A file descriptor that closes itself.
class Socket {
 public:
  Socket() = default;
  explicit Socket(int fd) : fd_(fd) {}
  Socket(Socket&& other) noexcept;
  Socket& operator=(Socket&& other) noexcept;
  ~Socket();

  bool is_open() const noexcept { return fd_ >= 0; }
  void close() noexcept;

  // Waits for the next frame until `give_up_ns` of CLOCK_MONOTONIC. disconnected: the interface is down or
  // was removed.
  ReceiveResult receive(ReceivedFrame& out, std::int64_t give_up_ns) noexcept;

  // False: the transmit queue is full or the interface was removed. Never waits.
  bool send(std::uint32_t id, std::span<const std::uint8_t> bytes) noexcept;

 private:
  int fd_ = -1;
};

// Opens an interface. The socket receives only these ids and error frames. Throws DriverError.
Socket open_interface(const std::string& interface, const std::vector<std::uint32_t>& ids);

}  // namespace slipd::can
