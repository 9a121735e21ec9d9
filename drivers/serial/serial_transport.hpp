// Bytes of a serial line, and the requests of a device that only answers (Modbus-like). Acquire thread;
// nothing allocates after construction.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/decode/stream_driver.hpp"
#include "drivers/serial/serial_port.hpp"

namespace slipd::serial {

// Asks a device round after round: each request once in a round, the next one when the last was answered or
// its time is over. Rounds begin at the profile's rate, or as fast as answers come.
class Poller {
 public:
  // requests: none: the device sends by itself.
  Poller(const std::vector<decode::SerialRequest>& requests, double rate_hz);

  // The request to send now; null: none.
  const decode::SerialRequest* due(std::int64_t now_ns) const noexcept;
  // When to look again, CLOCK_MONOTONIC; INT64_MAX: nothing is asked.
  std::int64_t look_again_ns() const noexcept;
  void sent(std::int64_t now_ns) noexcept;
  void answered() noexcept;
  // Whether an answer is overdue; then the rest of the round is left out.
  bool expire(std::int64_t now_ns) noexcept;

 private:
  void end_round() noexcept;

  const std::vector<decode::SerialRequest> requests_;
  const std::int64_t period_ns_;
  std::size_t next_ = 0;           // of the round
  bool waits_ = false;             // for the answer to request next_
  std::int64_t answer_by_ns_ = 0;  // while it waits
  std::int64_t round_ns_ = 0;      // when the round begins
};

class SerialTransport final : public decode::Transport {
 public:
  // Set-up thread. Opens the line and sends the start messages. Throws DriverError.
  SerialTransport(const std::string& path, const decode::Profile& profile, const decode::SerialLine& line);
  ~SerialTransport() override;
  SerialTransport(const SerialTransport&) = delete;
  SerialTransport& operator=(const SerialTransport&) = delete;

  decode::ReceiveResult receive(decode::ReceivedBytes& out, std::int64_t give_up_ns) noexcept override;
  void restart() noexcept override;
  void answered() noexcept override { poller_.answered(); }
  std::string why_no_frames(std::uint64_t garbage) const override;

 private:
  decode::ReceiveResult deliver(decode::ReceivedBytes& out) noexcept;

  const decode::SerialLine line_;
  const std::vector<decode::Message> start_, stop_;
  SerialPort port_;
  Poller poller_;
  std::array<std::uint8_t, 4096> held_{};
  std::size_t count_ = 0;       // of the bytes held, which silence has not ended yet
  std::int64_t last_ns_ = 0;    // when the last of them came
  std::uint64_t received_ = 0;  // bytes since it was opened
};

}  // namespace slipd::serial
