// One CAN interface, as an interface that tests can replace.
#pragma once

#include <array>
#include <cstdint>

#include "daemon/can/encode.hpp"

namespace slipd::can {

// An error frame of the controller.
struct BusError {
  // Flags CAN_ERR_… of linux/can/error.h.
  std::uint32_t kind = 0;
  // As linux/can/error.h describes it.
  std::array<std::uint8_t, 8> data{};
};

// Not thread-safe. Called from one thread: can. No function blocks, throws or allocates.
class Port {
 public:
  virtual ~Port() = default;
  // Opens the interface, closing it first if it is open. Returns 0 or an errno.
  virtual int open() noexcept = 0;
  virtual void close() noexcept = 0;
  // Queues a message in the kernel. Returns 0 or an errno.
  virtual int send(const Message& message) noexcept = 0;
  // Takes the oldest error frame; false: there is none.
  virtual bool next_error(BusError& error) noexcept = 0;
};

}  // namespace slipd::can
