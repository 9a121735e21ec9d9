// A file of one sensor's frames, played from its start: what a recording and a CSV have in common.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "core/frame/frame.hpp"
#include "driver_api/driver.hpp"

namespace slipd::replay {

enum class Next : std::uint8_t { frame, corrupt, end, damaged };

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  // Acquire thread. Fills all of `out` as the file has it: time_ns from an origin of the file's own, values
  // raw. Allocates and throws nothing, may wait for the disk. damaged: fault() says what and where.
  virtual Next next(FrameSlot& out) noexcept = 0;
  virtual void rewind() noexcept = 0;
  virtual std::string fault() const = 0;

  // Set-up. 0: the file does not say.
  virtual double rate_hz() const noexcept = 0;
  virtual SensorClass sensor_class() const noexcept = 0;
  virtual bool zeroed() const noexcept = 0;  // see SensorInfo
};

// Looks into the file for what it is and opens it for this sensor. Throws DriverError naming file and place
// for a file that cannot be read, is neither recording nor CSV, or does not fit the sensor's layout.
std::unique_ptr<FrameSource> open_source(const std::filesystem::path& file, const SensorSetup& sensor);

}  // namespace slipd::replay
