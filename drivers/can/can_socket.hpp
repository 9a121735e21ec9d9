// A raw SocketCAN socket as the driver wants it. Opened by the set-up thread, read by the acquire thread,
// which allocates nothing here.
#pragma once

#include <linux/can.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace slipd::can {

// One frame with the time at which the kernel got it from the controller.
struct Arrival {
  canfd_frame frame{};       // a classic one, too: len says how much of it
  std::int64_t time_ns = 0;  // CLOCK_MONOTONIC
};

enum class Got : std::uint8_t { frame, nothing, gone };

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

  // The next frame, waited for until `give_up_ns` of CLOCK_MONOTONIC. gone: the interface is down or away.
  Got receive(Arrival& out, std::int64_t give_up_ns) noexcept;

  // False: the transmit queue is full or the interface gone. Never waits.
  bool send(std::uint32_t id, std::span<const std::uint8_t> bytes) noexcept;

 private:
  int fd_ = -1;
};

// The socket of an interface, which receives only these ids and error frames. Throws DriverError.
Socket open_interface(const std::string& interface, const std::vector<std::uint32_t>& ids);

}  // namespace slipd::can
