// The USB driver's transport on a MemoryBus: each packet of the simulated device is one transfer.
#pragma once

#include "drivers/pacing.hpp"
#include "drivers/usb/usb_driver.hpp"
#include "tests/devices/memory_port.hpp"

namespace slipd::test {

class MemoryTransport final : public usb::Transport {
 public:
  MemoryTransport(std::shared_ptr<devices::MemoryBus> bus, const decode::Profile& profile)
      : bus_(std::move(bus)), start_(profile.start), out_(profile.usb->out) {
    restart();
  }

  usb::ReceiveResult receive(usb::ReceivedBytes& out, std::int64_t give_up_ns) noexcept override {
    try {
      auto packet =
          bus_->receive(std::chrono::nanoseconds(std::max<std::int64_t>(0, give_up_ns - monotonic_ns())));
      if (!packet) return usb::ReceiveResult::timeout;
      held_ = std::move(*packet);
      out = {held_.bytes, monotonic_ns()};
      return usb::ReceiveResult::bytes;
    } catch (const devices::MemoryBus::Gone&) {
      return usb::ReceiveResult::disconnected;
    }
  }

  void restart() noexcept override {
    for (const decode::Message& message : start_) {
      if (message.control) {
        const auto& c = *message.control;
        bus_->request({c.type, c.request, c.value, c.index, c.length});
      } else {
        bus_->say({out_, message.bytes});
      }
    }
  }

 private:
  std::shared_ptr<devices::MemoryBus> bus_;
  std::vector<decode::Message> start_;
  std::uint8_t out_;
  devices::Packet held_;
};

inline usb::Opener memory_opener(std::shared_ptr<devices::MemoryBus> bus) {
  return [bus](const decode::Profile& profile, const usb::DeviceSelector&) -> usb::OpenedDevice {
    if (!bus->plugged()) throw DriverError("nothing is plugged in");
    return {std::make_unique<MemoryTransport>(bus, profile), "memory", "SIM0001"};
  };
}

}  // namespace slipd::test
