// A recording (core/recording/recording.hpp) as a source of frames.
#pragma once

#include "core/recording/recording.hpp"
#include "drivers/replay/source.hpp"

namespace slipd::replay {

class RecordingSource final : public FrameSource {
 public:
  // Throws DriverError as open_source says.
  RecordingSource(const std::filesystem::path& file, const SensorSetup& sensor);

  ReadOutcome next(FrameSlot& out) noexcept override;
  void rewind() noexcept override { reader_.rewind(); }
  bool has_fault() const noexcept override { return reader_.has_fault(); }
  std::string fault() const override { return reader_.fault(); }
  double rate_hz() const noexcept override { return reader_.header().rate_hz; }
  SensorClass sensor_class() const noexcept override { return reader_.header().sensor_class; }
  bool zeroed() const noexcept override { return reader_.header().zeroed; }

 private:
  RecordingReader reader_;
};

}  // namespace slipd::replay
