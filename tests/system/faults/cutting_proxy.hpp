// A proxy between slipd and a Modbus TCP device. It forwards all bytes and closes each connection in the
// middle of an answer, like a device that loses power. It runs in a thread of its own.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

#include "core/storage/unique_fd.hpp"

namespace slipd::testing {

class CuttingProxy {
 public:
  // Connects to the device at this port of the loopback interface.
  explicit CuttingProxy(std::uint16_t device_port);

  std::uint16_t port() const noexcept { return port_; }
  int cuts() const noexcept { return cuts_; }
  void stop_cutting() noexcept { cutting_ = false; }

 private:
  void run(const std::stop_token& stop);
  void pass_on(const std::stop_token& stop, const UniqueFd& slipd);
  const std::uint16_t device_port_;
  std::uint16_t port_ = 0;
  UniqueFd listener_;
  std::atomic<int> cuts_{0};
  std::atomic<bool> cutting_{true};
  std::jthread thread_;
};

}  // namespace slipd::testing
