// Frames of displacements that slipd-camera makes of a video file. It runs as a child process and writes them
// to a pipe as it would send them to slipd (push_layout/layout.hpp).
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/frame/frame.hpp"
#include "driver_api/driver.hpp"
#include "drivers/push/frame_reader.hpp"
#include "drivers/replay/source.hpp"

namespace sliplab {

// Whether the file is a video, by its name.
bool is_video(const std::filesystem::path& file);

class CameraFrames {
 public:
  // Starts slipd-camera: the one beside this program, else of PATH. The sensor's option camera_profile names
  // its profile. Throws slipd::DriverError if it cannot run, refuses the file, or makes frames of another
  // layout.
  CameraFrames(const slipd::SensorSetup& sensor, const std::string& file);
  CameraFrames(const CameraFrames&) = delete;
  CameraFrames& operator=(const CameraFrames&) = delete;
  ~CameraFrames();

  slipd::SensorClass sensor_class() const noexcept { return agreed_.sensor_class(); }
  // The frame of the next picture; corrupt: the picture shows none.
  slipd::replay::ReadOutcome next(slipd::FrameSlot& out);
  // Why it ended before the file did; empty: it did not.
  const std::string& fault() const noexcept { return fault_; }

 private:
  bool receive(std::size_t bytes);
  void begin(const slipd::SensorSetup& sensor);
  int end_child() noexcept;

  std::string file_, fault_;
  pid_t child_ = -1;
  int pipe_ = -1;
  std::vector<std::uint8_t> message_;
  slipd::push::Agreement agreed_;
  slipd::push::FrameReader reader_;
  std::int64_t last_ns_ = 0;
};

}  // namespace sliplab
