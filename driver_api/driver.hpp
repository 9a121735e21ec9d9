// The whole contract between slipd and a driver. A driver turns one device's bytes into frames; the device
// may carry several sensors (two fingers, boards on one bus). It is a loadable module, slipd-driver-NAME.so,
// that exports `extern "C" const slipd::DriverModule* slipd_driver_module()`, which SLIPD_DRIVER_MODULE
// defines.
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

// One sensor as the configuration names it. `layout`: from the configuration, for drivers whose device does
// not dictate one. `options`: the driver's own, validated against its schema, with defaults filled in.
struct SensorSetup {
  std::string name;
  TaxelLayout layout;
  double rate_hz = 1000;
  double skin_radius_m = 0.01;  // infinity: flat
  double skin_modulus_pa = 0.5e6;
  double skin_poisson = 0.45;
  std::string profile;     // empty: none
  nlohmann::json device;   // how to find it: serial, index, port …; an object
  nlohmann::json options;  // an object
  bool operator==(const SensorSetup&) const = default;
};

// The surface of a sensor whose device dictates it; see Skin of the scene.
struct SkinInfo {
  double radius_m = 0.01;  // infinity: flat
  double modulus_pa = 0.5e6;
  double poisson = 0.45;
};

struct SensorInfo {
  SensorClass sensor_class = SensorClass::array3;
  TaxelLayout layout;
  double rate_hz = 0;                 // 0: unknown
  std::optional<SkinInfo> skin = {};  // none: the one of the configuration
  // Whether frames read 0 without load: the device zeroes itself, or its values come from nowhere else.
  // false: slipd finds out what it reads without load, keeps that on disk, and tells no margin before it
  // knows.
  bool zeroed = false;
  // Which of the device's sensors this is, where that is the same at each start: "board 1". Under it, and
  // DeviceInfo::serial, the zero is kept. Empty: under the name of the sensor in the configuration.
  std::string part = {};
  // The smallest differences that the device tells, which nobody can take for a load; 0: it is not known.
  double step_normal_pa = 0, step_shear_pa = 0;
};

struct DeviceInfo {
  std::string description;  // for people: "simulated 100 x 100", "XELA XR1944 on can0"
  std::string serial;       // empty: it has none
  bool simulated = false;
  std::vector<SensorInfo> sensors;  // as many as SensorSetups were given, in their order
};

// Says what device, what is wrong, and what to do. Thrown by create and open only.
class DriverError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum class ReadStatus : std::uint8_t {
  frame,         // slots[sensor] holds a frame
  timeout,       // nothing within the time given; not an error
  corrupt,       // a packet or frame was dropped; counted, reading goes on
  disconnected,  // the device is gone; it will be closed and reopened with back-off
  end            // a recording is over; nothing will come again
};

struct ReadResult {
  ReadStatus status = ReadStatus::timeout;
  std::uint16_t sensor = 0;  // whose: index into slots
};

class DeviceDriver {
 public:
  virtual ~DeviceDriver() = default;

  // Set-up thread. May allocate and take its time (some seconds). Throws DriverError. Called again after
  // close.
  virtual DeviceInfo open() = 0;

  // Acquire thread. Fills slots[i] of the sensor i it says (spans sized by that sensor's layout) and returns
  // within about `timeout`. Must not allocate, lock, log or throw in its own code.
  virtual ReadResult read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept = 0;

  // Set-up or acquire thread. Idempotent.
  virtual void close() noexcept = 0;

  // Whether frames come from a clock that can be held back (a recording played as fast as it goes): then
  // slipd waits for the estimator instead of skipping. Constant after open.
  virtual bool paced_by_consumer() const noexcept { return false; }
};

// The module's table. `options_schema` is a JSON Schema (the subset of schema/schema.hpp, with "unit"): the
// one source for validation, defaults, `slipd --list-drivers` and the documentation.
struct DriverModule {
  std::uint32_t abi;           // kDriverAbi of the headers it was built with
  const char* name;            // "sim"; the file is slipd-driver-sim.so
  const char* summary;         // one line
  const char* options_schema;  // JSON text, of an object
  // Setup sensors of one device; throws DriverError for what a schema cannot say.
  std::unique_ptr<DeviceDriver> (*create)(const std::vector<SensorSetup>& sensors);
};

inline constexpr std::uint32_t kDriverAbi = 4;
inline constexpr const char* kDriverSymbol = "slipd_driver_module";

}  // namespace slipd

#define SLIPD_DRIVER_MODULE(table)                                                                     \
  extern "C" __attribute__((visibility("default"))) const slipd::DriverModule* slipd_driver_module() { \
    return &(table);                                                                                   \
  }
