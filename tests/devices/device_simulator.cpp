#include "tests/devices/device_simulator.hpp"

#include <sys/timerfd.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <stdexcept>

namespace slipd::devices {
namespace {

std::int64_t now_ns() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

void put_number(std::ostream& out, const char* key, double value) {
  out << ",\"" << key << "\":";
  if (std::isfinite(value)) {
    out << value;
  } else {
    out << "null";
  }
}

}  // namespace

DeviceSimulator::DeviceSimulator(const DeviceModel& model, std::vector<Contact> contacts,
                                 std::unique_ptr<Port> port, std::ostream* truth)
    : model_(model), port_(std::move(port)), truth_(truth) {
  if (contacts.size() != model.sensors) throw std::invalid_argument("one contact for each sensor, please");
  const std::size_t taxels = model.layout.size();
  for (Contact& contact : contacts) {
    Sensor& sensor = sensors_.emplace_back(Sensor{std::move(contact), std::vector<float>(3 * taxels), {}});
    const std::span memory(sensor.memory);
    sensor.slot.normal_pa = memory.subspan(0, taxels);
    sensor.slot.shear_x_pa = memory.subspan(taxels, taxels);
    sensor.slot.shear_y_pa = memory.subspan(2 * taxels, taxels);
  }
  port_->plug();
}

DeviceSimulator::~DeviceSimulator() {
  port_->unplug();
}

void DeviceSimulator::order(const std::string& text) {
  order_at(0, text);
}

void DeviceSimulator::order_at(std::uint64_t scan, const std::string& text) {
  const Misbehaviour::Order order = Misbehaviour::parse(text);
  const std::lock_guard lock(mutex_);
  orders_.emplace(scan, order);
}

bool DeviceSimulator::carry_out_orders() {
  const std::lock_guard lock(mutex_);
  while (!orders_.empty() && orders_.begin()->first <= scan_) {
    const Misbehaviour::Order order = orders_.begin()->second;
    orders_.erase(orders_.begin());
    if (truth_) *truth_ << "{\"scan\":" << scan_ << ",\"order\":\"" << order.text() << "\"}" << std::endl;
    switch (order.kind) {
      case Misbehaviour::Kind::quit:
        return false;
      case Misbehaviour::Kind::unplug:
        port_->unplug();
        break;
      case Misbehaviour::Kind::plug:
        port_->plug();
        break;
      case Misbehaviour::Kind::stall:
        stalled_ = order.scans;
        break;
      default:
        now_ = order;
    }
  }
  return true;
}

std::vector<Packet> DeviceSimulator::next_scan() {
  std::vector<Frame> frames;
  for (Sensor& sensor : sensors_) {
    sensor.slot.sequence = scan_;
    sensor.slot.time_ns = now_ns();
    sensor.contact(sensor.slot);
    frames.push_back(sensor.slot.view());
  }
  return model_.scan(
      {frames, scan_, static_cast<std::uint64_t>(static_cast<double>(scan_) * 1e6 / model_.rate_hz)});
}

void DeviceSimulator::write_truth() {
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    double normal = 0, x = 0, y = 0;
    const FrameSlot& slot = sensors_[i].slot;
    for (std::size_t taxel = 0; taxel < model_.layout.size(); ++taxel) {
      normal += slot.normal_pa[taxel] * model_.layout.area_m2();
      x += slot.shear_x_pa[taxel] * model_.layout.area_m2();
      y += slot.shear_y_pa[taxel] * model_.layout.area_m2();
    }
    *truth_ << "{\"scan\":" << scan_ << ",\"sensor\":" << i << ",\"time_ns\":" << now_ns();
    put_number(*truth_, "gamma", slot.truth.gamma);
    put_number(*truth_, "friction", slot.truth.friction);
    put_number(*truth_, "normal_n", normal);
    put_number(*truth_, "shear_n", std::hypot(x, y));
    *truth_ << "}" << std::endl;
  }
}

bool DeviceSimulator::step() {
  if (!carry_out_orders()) return false;
  std::vector<Packet> scan = next_scan();  // the contact advances also while the device sends nothing
  port_->silence(stalled_ > 0);
  if (stalled_ > 0) {
    --stalled_;
  } else if (port_->streaming()) {
    if (now_.scans > 0) {
      misbehaviour_.distort(now_.kind, scan);
      --now_.scans;
    }
    port_->send(scan);
    if (truth_) write_truth();
  }
  ++scan_;
  return true;
}

void DeviceSimulator::run(std::stop_token stop, double rate_hz, std::uint64_t scans) {
  const Fd timer(checked(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK), "timer"));
  const auto period_ns = static_cast<std::int64_t>(1e9 / rate_hz);
  const timespec period{period_ns / 1'000'000'000, period_ns % 1'000'000'000};
  const itimerspec every{period, period};
  checked(::timerfd_settime(timer.get(), 0, &every, nullptr), "timer");

  for (std::uint64_t done = 0; !stop.stop_requested();) {
    std::vector<pollfd> waits{{timer.get(), POLLIN, 0}};
    port_->watch(waits);
    ::poll(waits.data(), waits.size(), 1000);
    port_->serve();
    std::uint64_t due = 0;
    if (::read(timer.get(), &due, sizeof due) != sizeof due) continue;
    // After a delay the device does not send missed scans; it continues with the present one.
    if (!step() || ++done == scans) return;
  }
}

}  // namespace slipd::devices
