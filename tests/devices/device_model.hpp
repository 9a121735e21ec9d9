// A simulated device: its data, and the encoding of one scan in bytes. Each device has a file
// (xela_xr1944.cpp and so on). Byte layouts are those of public drivers and data models; where no source
// gives a scale, it is chosen here. Transport, pacing and misbehaviour are common to all devices: see
// port.hpp and device_simulator.hpp.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "tests/devices/bytes.hpp"

namespace slipd::devices {

// The input of one scan.
struct ScanInput {
  std::span<const Frame> sensors;  // one frame for each of the device's sensors
  std::uint64_t scan = 0;          // scans since it was plugged in
  std::uint64_t time_us = 0;       // the device's clock
};

// The device's state as the host has set it.
struct HostState {
  bool streaming = false;
};

struct UsbRequest {
  std::uint8_t type = 0, request = 0;
  std::uint16_t value = 0, index = 0, length = 0;
};

struct UsbModel {
  std::uint16_t vendor = 0, product = 0;
  std::uint8_t device_class = 0;
  std::uint8_t in_endpoint = 0x81;
  Bytes configuration;  // configuration, interface and endpoint descriptors; the total length is filled in
  // Class and vendor requests with data to the host: returns the data, or nothing for a stall.
  std::optional<Bytes> (*request)(const UsbRequest&, HostState&) = nullptr;
};

struct HidModel {
  std::uint16_t vendor = 0, product = 0;
  Bytes report_descriptor;
};

struct ModbusModel {
  int unit = 1;
  int baud = 0;  // RTU only; 0: TCP
  int first_register = 0;
  int registers = 0;
};

struct DeviceModel {
  std::string_view name;                           // "xela-xr1944"
  std::string_view summary;                        // for people, and the product's name on USB and HID
  SensorClass sensor_class = SensorClass::array3;  // what the sensors measure
  TaxelLayout layout;                              // of each sensor
  std::size_t sensors = 1;                         // in the device
  double rate_hz = 100;                            // scans per second
  bool starts_by_itself = true;                    // false: it sends after a start message
  // One scan in the device's bytes, in the order in which they leave. reading.sensors has `sensors` frames.
  std::vector<Packet> (*scan)(const ScanInput&) = nullptr;
  // A packet from the host; null: the device ignores them.
  void (*receive)(const Packet&, HostState&) = nullptr;
  std::optional<UsbModel> usb = {};
  std::optional<HidModel> hid = {};
  std::optional<ModbusModel> modbus = {};
};

const DeviceModel& xela_xr1944();
const DeviceModel& icub_skin();
const DeviceModel& takktile();
const DeviceModel& papillarray();
const DeviceModel& robotiq_tsf85();
const DeviceModel& vendor_hid();
const DeviceModel& onrobot_rg2ft();
const DeviceModel& robotiq_ft300();
const DeviceModel& optoforce();
const DeviceModel& space_mouse();
const DeviceModel& rohand();
const DeviceModel& hid_force();

// All models, and one by its name (null: unknown).
std::vector<const DeviceModel*> all_models();
const DeviceModel* find_model(std::string_view name);

// The force on one taxel.
struct Force {
  double x_n = 0, y_n = 0, z_n = 0;  // z is the normal force, positive when pressed
};
inline Force force_of(const Frame& frame, const TaxelLayout& layout, std::size_t taxel = 0) {
  return {frame.shear_x_pa[taxel] * layout.area_m2(), frame.shear_y_pa[taxel] * layout.area_m2(),
          frame.normal_pa[taxel] * layout.area_m2()};
}

}  // namespace slipd::devices
