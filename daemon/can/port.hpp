// One CAN interface as the CAN thread sees it, so that tests need no kernel that has one.
#pragma once

#include <array>
#include <cstdint>

#include "daemon/can/encode.hpp"

namespace slipd::can {

// An error frame: what the controller says of the bus. `kind`: CAN_ERR_… of linux/can/error.h.
struct BusError {
  std::uint32_t kind = 0;
  std::array<std::uint8_t, 8> data{};
};

// CAN thread; nothing blocks, throws or allocates.
class Port {
 public:
  virtual ~Port() = default;
  virtual int open() noexcept = 0;  // 0, or the errno; a port that is open is closed first
  virtual void close() noexcept = 0;
  virtual int send(const Message& message) noexcept = 0;  // 0, or the errno
  virtual bool next_error(BusError& error) noexcept = 0;  // false: there is no more
};

}  // namespace slipd::can
