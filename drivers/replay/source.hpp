// A file of one sensor's frames, read from its start: the interface of recordings and CSV files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "core/frame/frame.hpp"
#include "driver_api/driver.hpp"

namespace slipd::replay {

enum class ReadOutcome : std::uint8_t {
  frame,    // a frame was read
  corrupt,  // a frame or a block of frames was skipped
  none,     // nothing yet: one call reads no more than so much
  end,      // the file is at its end; fault() says what of it was damaged
  damaged   // the file cannot be read on, see fault()
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  // Acquire thread. Fills `out` with the file's values: time_ns from the file's own origin, taxels raw.
  // Allocates nothing, does not throw, can wait for the disk.
  virtual ReadOutcome next(FrameSlot& out) noexcept = 0;
  virtual void rewind() noexcept = 0;
  virtual bool has_fault() const noexcept = 0;  // whether anything damaged was met since rewind
  virtual std::string fault() const = 0;        // what is damaged and where; empty: nothing

  // Set-up thread.
  virtual double rate_hz() const noexcept = 0;  // 0: unknown
  virtual SensorClass sensor_class() const noexcept = 0;
  virtual bool zeroed() const noexcept = 0;  // see SensorInfo
};

// Detects the file's format from its first bytes and opens it for this sensor. Throws DriverError, which
// names file and place, for a file that cannot be read, is neither recording nor CSV, or has another layout.
std::unique_ptr<FrameSource> open_source(const std::filesystem::path& file, const SensorSetup& sensor);

}  // namespace slipd::replay
