// The frames of a file as a sensor of a scene would give them: with the scene's layout, units and gains, and
// its bias subtracted.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/chain/chain.hpp"
#include "core/frame/frame.hpp"

namespace slipd {
struct Settings;
}

namespace sliplab {

// One file, and the sensor of the scene that it is of.
struct FileOfSensor {
  std::string sensor, file;
};

class FileFrames {
 public:
  enum class Outcome : std::uint8_t { frame, corrupt, end };

  // Throws slipd::SettingsError or slipd::DriverError.
  FileFrames(const slipd::Settings& settings, const FileOfSensor& of);
  FileFrames(FileFrames&&) noexcept;
  FileFrames& operator=(FileFrames&&) noexcept;
  ~FileFrames();

  // What an EstimatorChain of this sensor needs.
  const slipd::ChainSetup& setup() const noexcept;
  // The next frame, valid until the next call; corrupt: it cannot be used, and the next may.
  Outcome next();
  slipd::Frame frame() const noexcept;
  std::int64_t time_ns() const noexcept;
  // Frames so far whose time in the file was not later than that of the frame before.
  std::size_t unrisen() const noexcept;
  // Frames a second that the file should have: by its header, or else the sensor's rate_hz; none: of a video.
  std::optional<double> rate_hz() const noexcept;
  // Where and why the file could not be read to its end; empty: it was.
  const std::string& fault() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

slipd::Settings load_scene(const std::filesystem::path& scene);

// Which file goes with which sensor, as for replay() in run.hpp. Throws WrongUse.
std::vector<FileOfSensor> files_of(const slipd::Settings& settings, const std::string& sensor,
                                   const std::vector<std::string>& files);

}  // namespace sliplab
