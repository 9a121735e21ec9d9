// A serial line: a UART, a USB adapter, a USB modem port (CDC-ACM). 8 data bits, raw, non-blocking; no other
// program opens it meanwhile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "core/storage/unique_fd.hpp"
#include "drivers/decode/profile.hpp"

namespace slipd::serial {

// What the line reports of bytes that were no bytes; since it was opened.
struct LineErrors {
  std::uint32_t framing = 0;  // no stop bit where one has to be: most often a wrong baud rate
  std::uint32_t parity = 0;
  std::uint32_t overrun = 0;  // bytes lost in the adapter or the kernel
};

class SerialPort {
 public:
  // Set-up thread. Opens and sets the line, forgets what it has received. Throws DriverError.
  SerialPort(const std::string& path, const decode::SerialLine& line);

  // Acquire thread. Waits for bytes until `until_ns`, CLOCK_MONOTONIC. Returns how many were read into
  // `into`; 0: none came; -1: the line is gone.
  std::ptrdiff_t read(std::span<std::uint8_t> into, std::int64_t until_ns) noexcept;
  // Acquire thread. False: they were not all taken.
  bool write(std::span<const std::uint8_t> bytes) noexcept;

  // None where the line does not count them (a pseudo-terminal).
  LineErrors errors() const noexcept;

 private:
  LineErrors counted() const noexcept;

  UniqueFd fd_;
  LineErrors before_;  // when it was opened
};

}  // namespace slipd::serial
