// The contract between slipd and a driver. A driver turns one device's bytes into frames; the device can have
// several sensors (two fingers, boards on one bus). A driver is a loadable module, slipd-driver-NAME.so, that
// exports `extern "C" const slipd::DriverModule* slipd_driver_module()`, which SLIPD_DRIVER_MODULE defines.
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

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"

namespace slipd {

// One sensor of the configuration.
struct SensorSetup {
  std::string name;                // unique in the configuration
  TaxelLayout layout;              // the configuration's, for drivers whose device does not determine it
  double rate_hz = 1000;           // frames per second, > 0
  double skin_radius_m = 0.01;     // radius of curvature, m, > 0; infinity: flat
  double skin_modulus_pa = 0.5e6;  // Young's modulus, Pa, > 0
  double skin_poisson = 0.45;      // Poisson's ratio, 0 … 0.5
  std::string profile;             // name of the device's profile; empty: none
  nlohmann::json device;           // how to find the device: serial, index, port …; an object
  nlohmann::json options;  // the driver's own, valid by its schema, with defaults filled in; an object
  bool operator==(const SensorSetup&) const = default;
};

// The surface of a sensor whose device determines it; see Skin of the scene.
struct SkinInfo {
  double radius_m = 0.01;     // radius of curvature, m, > 0; infinity: flat
  double modulus_pa = 0.5e6;  // Young's modulus, Pa, > 0
  double poisson = 0.45;      // Poisson's ratio, 0 … 0.5
};

// What a driver reports of one sensor of an open device.
struct SensorInfo {
  SensorClass sensor_class = SensorClass::array3;  // the channels that it measures
  TaxelLayout layout;                              // of its frames
  double rate_hz = 0;                              // frames per second; 0: unknown
  std::optional<SkinInfo> skin = {};               // absent: that of the configuration
  // true: values are 0 without load, because the device zeroes itself or its values are computed. false:
  // slipd estimates the values without load, stores them on disk, and reports no margin before it has them.
  bool zeroed = false;
  // Identifies the sensor in the device where that is the same at each start: "board 1". The stored bias is
  // found by it and DeviceInfo::serial. Empty: by the sensor's name in the configuration.
  std::string part = {};
  double step_normal_pa = 0;  // resolution of the normal pressure, Pa; 0: unknown
  double step_shear_pa = 0;   // resolution of the shear, Pa; 0: unknown
};

// What a driver reports of an open device.
struct DeviceInfo {
  std::string description;  // for people: "simulated 100 x 100", "XELA XR1944 on can0"
  std::string serial;       // empty: it has none
  bool simulated = false;   // frames are computed or recorded; by default no CAN output is made of them
  std::vector<SensorInfo> sensors;  // one for each SensorSetup, in their order
};

// Names the device, the fault and the remedy. Thrown by create and open only.
class DriverError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum class ReadStatus : std::uint8_t {
  frame,         // slots[sensor] holds a frame
  timeout,       // no frame within the time-out; not an error
  corrupt,       // a packet or frame was dropped; slipd counts it and reads on
  disconnected,  // the device is gone; slipd closes it and reopens it with back-off
  end            // a recording is at its end; no frame will follow
};

struct ReadResult {
  ReadStatus status = ReadStatus::timeout;
  std::uint16_t sensor = 0;  // index into slots
};

class DeviceDriver {
 public:
  virtual ~DeviceDriver() = default;

  // Set-up thread. May allocate and take some seconds. Throws DriverError. Called again after close.
  virtual DeviceInfo open() = 0;

  // Acquire thread. Fills slots[i] of the sensor i that it returns (spans have the size of that sensor's
  // layout) and returns within about `timeout`. Must not allocate, lock, log or throw in its own code.
  virtual ReadResult read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept = 0;

  // Set-up or acquire thread. Idempotent.
  virtual void close() noexcept = 0;

  // true: the source can wait for its consumer (a recording played as fast as frames are taken); then slipd
  // skips no frame but waits for the estimator. Constant after open.
  virtual bool paced_by_consumer() const noexcept { return false; }
};

// The module's table.
struct DriverModule {
  std::uint32_t abi;    // kDriverAbi of the headers with which it was built
  const char* name;     // "sim"; the file is slipd-driver-sim.so
  const char* summary;  // one line, for people
  // JSON Schema text of an object (the subset of schema/schema.hpp, with "unit"): the source of validation,
  // defaults, `slipd --list-drivers` and the documentation.
  const char* options_schema;
  // Creates the driver of one device with these sensors; throws DriverError for what a schema cannot express.
  std::unique_ptr<DeviceDriver> (*create)(const std::vector<SensorSetup>& sensors);
};

inline constexpr std::uint32_t kDriverAbi = 4;
inline constexpr const char* kDriverSymbol = "slipd_driver_module";

}  // namespace slipd

#define SLIPD_DRIVER_MODULE(table)                                                                     \
  extern "C" __attribute__((visibility("default"))) const slipd::DriverModule* slipd_driver_module() { \
    return &(table);                                                                                   \
  }
