#include "tests/devices/memory_port.hpp"

namespace slipd::devices {
namespace {

class MemoryPort final : public Port {
 public:
  MemoryPort(const DeviceModel& model, std::shared_ptr<MemoryBus> bus) : Port(model), bus_(std::move(bus)) {}

  void watch(std::vector<pollfd>&) const override {}

  void serve() override {
    for (const Packet& packet : bus_->said()) {
      if (plugged_ && model_.receive) model_.receive(packet, host_state_);
    }
    for (const UsbRequest& request : bus_->requested()) {
      if (plugged_ && model_.usb && model_.usb->request) model_.usb->request(request, host_state_);
    }
  }

  void send(std::span<const Packet> scan) override {
    for (const Packet& packet : scan) bus_->push(packet);
  }

  void plug() override {
    if (plugged_) return;
    start();
    bus_->plug(true);
  }

  void unplug() override {
    plugged_ = false;
    bus_->plug(false);
  }

  std::string place() const override { return "memory"; }

 private:
  std::shared_ptr<MemoryBus> bus_;
};

}  // namespace

bool MemoryBus::plugged() const {
  const std::lock_guard lock(mutex_);
  return plugged_;
}

std::optional<Packet> MemoryBus::receive(std::chrono::nanoseconds patience) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, patience, [this] { return !plugged_ || !to_host_.empty(); });
  if (!plugged_) throw Gone{};
  if (to_host_.empty()) return std::nullopt;
  Packet packet = std::move(to_host_.front());
  to_host_.pop_front();
  return packet;
}

void MemoryBus::say(const Packet& packet) {
  const std::lock_guard lock(mutex_);
  to_device_.push_back(packet);
}

void MemoryBus::request(const UsbRequest& request) {
  const std::lock_guard lock(mutex_);
  requests_.push_back(request);
}

void MemoryBus::plug(bool in) {
  const std::lock_guard lock(mutex_);
  plugged_ = in;
  to_host_.clear();
  changed_.notify_all();
}

void MemoryBus::push(const Packet& packet) {
  const std::lock_guard lock(mutex_);
  to_host_.push_back(packet);
  if (to_host_.size() > kHeld) to_host_.pop_front();
  changed_.notify_all();
}

std::vector<Packet> MemoryBus::said() {
  const std::lock_guard lock(mutex_);
  return std::exchange(to_device_, {});
}

std::vector<UsbRequest> MemoryBus::requested() {
  const std::lock_guard lock(mutex_);
  return std::exchange(requests_, {});
}

std::unique_ptr<Port> make_memory_port(const DeviceModel& model, std::shared_ptr<MemoryBus> bus) {
  return std::make_unique<MemoryPort>(model, std::move(bus));
}

}  // namespace slipd::devices
