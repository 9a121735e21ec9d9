// The contract between slipd and a driver. A driver converts one device's bytes into frames. A device may
// have several sensors (two fingers, several boards on one bus). A driver is a loadable module,
// slipd-driver-NAME.so, that exports `extern "C" const slipd::DriverModule* slipd_driver_module()`; the macro
// SLIPD_DRIVER_MODULE defines it.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/contact/skin_base.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"

namespace slipd {

// One sensor as configured.
struct SensorSetup {
  // Unique among the sensors.
  std::string name;
  // Where its taxels are, for devices that do not define it.
  TaxelLayout layout;
  // Frames a second, above 0, for devices that do not define it.
  double rate_hz = 1000;
  // Radius of the skin's surface, m; infinity: flat.
  double skin_radius_m = 0.01;
  // Young's modulus of the skin, Pa; above 0.
  double skin_modulus_pa = 0.5e6;
  // Poisson's ratio of the skin, 0 to 0.5.
  double skin_poisson = 0.45;
  // Depth of the taxels under the skin's surface, m; 0: at the surface.
  double skin_depth_m = 0;
  // What they lie on.
  SkinBase skin_base = SkinBase::half_space;
  // Name of the device profile; empty: none.
  std::string profile;
  // How to find the device: serial, index, port, …; an object, empty if there is nothing to tell.
  nlohmann::json device;
  // Folder of slipd's socket, for sockets of a driver's own: "/run/slipd".
  std::string runtime_folder = {};
  // The driver's options: an object, checked against its schema, with defaults filled in.
  nlohmann::json options;
  bool operator==(const SensorSetup&) const = default;
};

// The skin of a sensor, for devices that define it; see Skin in core/contact/scene.hpp.
struct SkinInfo {
  // Radius of the surface, m; infinity: flat.
  double radius_m = 0.01;
  // Young's modulus, Pa; above 0.
  double modulus_pa = 0.5e6;
  // Poisson's ratio, 0 to 0.5.
  double poisson = 0.45;
  // Depth of the taxels under the surface, m; 0: at the surface.
  double depth_m = 0;
  // What they lie on.
  SkinBase base = SkinBase::half_space;
};

// What a driver reports of one sensor once its device is open.
struct SensorInfo {
  // What the sensor measures.
  SensorClass sensor_class = SensorClass::array3;
  // Where its taxels are; the size of the spans that read fills.
  TaxelLayout layout;
  // Frames a second; 0: unknown.
  double rate_hz = 0;
  // The skin, if the device defines it; none: as configured.
  std::optional<SkinInfo> skin = {};
  // Whether frames read 0 without load, because the device subtracts its bias or has none. False: slipd
  // measures the bias, keeps it on disk, and gives no margin before it is known.
  bool zeroed = false;
  // Whether values are pressures. False: numbers of an unknown scale, such as counts. slipd then knows no
  // zero and gives no margin; it sees whether the object slides.
  bool calibrated = true;
  // Which of the device's sensors this is, the same at each start: "board 1". The bias is kept under it and
  // DeviceInfo::serial. Empty: under the sensor's configured name.
  std::string part = {};
  // Resolution of normal pressure, Pa: changes up to this are not taken as load; 0: unknown.
  double step_normal_pa = 0;
  // Resolution of shear, Pa; the same.
  double step_shear_pa = 0;
};

// What a driver reports of a device once it is open.
struct DeviceInfo {
  // For people: "simulated 100 x 100", "XELA XR1944 on can0".
  std::string description;
  // The device's serial number; empty: it has none.
  std::string serial;
  // Whether frames come from a simulation.
  bool simulated = false;
  // One for each SensorSetup, in the same order.
  std::vector<SensorInfo> sensors;
};

// what() says which device, what is wrong, and what to do. Thrown by create and open only.
class DriverError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// What a read brought.
enum class ReadStatus : std::uint8_t {
  frame,         // slots[sensor] was filled
  timeout,       // no frame within the timeout; not an error
  corrupt,       // a packet or frame was dropped; it is counted, and reading continues
  disconnected,  // the device is gone; slipd closes it and reopens it with back-off
  end,           // a recording is over; read is not called again
  away,          // no frame within the timeout, since nobody sends any; reading continues until one comes
  changed        // what open() reported does not hold any more; slipd closes the device and opens it again
};

// The result of one read.
struct ReadResult {
  // What happened.
  ReadStatus status = ReadStatus::timeout;
  // The sensor that it concerns: index into slots.
  std::uint16_t sensor = 0;
};

// One device. Not thread-safe: slipd calls it from one thread at a time.
class DeviceDriver {
 public:
  virtual ~DeviceDriver() = default;

  // Called from one thread: acquire, before it enters real time. Opens the device. May allocate and wait for
  // some seconds. Throws DriverError. Called again after close.
  virtual DeviceInfo open() = 0;

  // Called from one thread: acquire, in real time. Fills slots[result.sensor], whose spans have the size of
  // that sensor's layout, and returns within about `timeout`. Must not allocate, lock, log or throw in its
  // own code.
  virtual ReadResult read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept = 0;

  // Called from one thread: acquire, out of real time; or the destructor's. Idempotent.
  virtual void close() noexcept = 0;

  // Whether the source of frames can wait (a recording played as fast as frames are taken). slipd then waits
  // for the estimator before the next read instead of skipping frames. Constant after open.
  virtual bool paced_by_consumer() const noexcept { return false; }

  // Called from one thread: acquire, out of real time, when an open device has completed no frame for some
  // seconds, and after `away`. Why the bytes that arrive make no frame, for people: "reports of 64 bytes
  // arrive, the profile expects 20". Empty: nothing arrives, or the driver cannot tell.
  virtual std::string why_no_frames() const { return {}; }
};

// The table that a module exports. It is constant and lives as long as the process.
struct DriverModule {
  // kDriverAbi of the headers that the module was built with.
  std::uint32_t abi;
  // "sim"; the file is slipd-driver-sim.so.
  const char* name;
  // What it is for, one line.
  const char* summary;
  // JSON text: a JSON Schema of an object, in the subset of schema/schema.hpp. Used for validation, defaults,
  // `slipd --list-drivers` and the documentation. Its "$defs"/"device" is the schema of the keys under
  // `device`; without it they may be any.
  const char* options_schema;
  // Makes the driver of one device that has these sensors, at least one. Touches no device. Called from one
  // thread: io. Throws DriverError for options that the schema cannot exclude.
  std::unique_ptr<DeviceDriver> (*create)(const std::vector<SensorSetup>& sensors);
};

// Version of this contract. A module of another version is not loaded.
inline constexpr std::uint32_t kDriverAbi = 8;
// The symbol that a module exports.
inline constexpr const char* kDriverSymbol = "slipd_driver_module";

}  // namespace slipd

// Defines the module's exported function; `table` is its DriverModule.
#define SLIPD_DRIVER_MODULE(table)                                                                     \
  extern "C" __attribute__((visibility("default"))) const slipd::DriverModule* slipd_driver_module() { \
    return &(table);                                                                                   \
  }
