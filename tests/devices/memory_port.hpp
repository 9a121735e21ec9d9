// A bus in this process's memory: it queues a simulated device's packets for a driver that reads through a
// fake of its bus's library. The thread of the DeviceSimulator calls the device's side, any thread the
// host's.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>

#include "tests/devices/port.hpp"

namespace slipd::devices {

class MemoryBus {
 public:
  // The host's side. receive: nothing if no packet comes within the time; throws Gone.
  struct Gone {};
  bool plugged() const;
  std::optional<Packet> receive(std::chrono::nanoseconds patience);
  void say(const Packet& packet);           // to the device
  void request(const UsbRequest& request);  // to its control pipe

  // The device's side.
  void plug(bool in);
  void push(const Packet& packet);
  std::vector<Packet> said();
  std::vector<UsbRequest> requested();

 private:
  // packets held for a host that does not read; the oldest are dropped
  static constexpr std::size_t kHeld = 64;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool plugged_ = false;
  std::deque<Packet> to_host_;
  std::vector<Packet> to_device_;
  std::vector<UsbRequest> requests_;
};

std::unique_ptr<Port> make_memory_port(const DeviceModel& model, std::shared_ptr<MemoryBus> bus);

}  // namespace slipd::devices
