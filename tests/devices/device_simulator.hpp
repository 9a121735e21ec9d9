// Runs a simulated device: encodes its sensors' frames in the device's bytes, distorts them as ordered, sends
// them through its port and records the truth. step() is one scan and reads no clock; run() paces it.
#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <ostream>
#include <stop_token>

#include "tests/devices/misbehaviour.hpp"
#include "tests/devices/port.hpp"

namespace slipd::devices {

// Fills the next frame of one sensor and its truth. The slot's spans have the layout's size.
using Contact = std::function<void(FrameSlot&)>;

class DeviceSimulator {
 public:
  // `contacts`: one for each sensor of the model. `truth` may be null; it gets a line of JSON for each frame
  // sent and each order carried out. Plugs the port in. Throws as Port::plug does.
  DeviceSimulator(const DeviceModel& model, std::vector<Contact> contacts, std::unique_ptr<Port> port,
                  std::ostream* truth = nullptr);
  ~DeviceSimulator();

  // Called from any thread. The order takes effect before the next scan, or before the scan with that
  // number. Throws std::invalid_argument.
  void order(const std::string& text);
  void order_at(std::uint64_t scan, const std::string& text);

  // Makes one scan. False after the order `quit`.
  bool step();

  // Serves the port and steps at `rate_hz`, until `stop` is requested, after the order `quit`, or after
  // `scans` scans (0: without end).
  void run(std::stop_token stop, double rate_hz, std::uint64_t scans = 0);

  Port& port() { return *port_; }

 private:
  struct Sensor {
    Contact contact;
    std::vector<float> memory;
    FrameSlot slot;
  };

  bool carry_out_orders();
  std::vector<Packet> next_scan();
  void write_truth();

  const DeviceModel& model_;
  std::vector<Sensor> sensors_;
  std::unique_ptr<Port> port_;
  std::ostream* truth_;
  std::uint64_t scan_ = 0;
  Misbehaviour misbehaviour_;
  Misbehaviour::Order now_{.scans = 0};  // the order that is in force
  int stalled_ = 0;                      // scans of silence to come
  std::mutex mutex_;                     // guards orders_
  std::multimap<std::uint64_t, Misbehaviour::Order> orders_;
};

}  // namespace slipd::devices
