// Plays recorded frames as a device. Of a damaged file what is whole is played: a recording without its
// damaged blocks, which count as corrupt; CSV and recordings of version 1 up to the damage. Then read()
// returns `disconnected`, and open() throws the fault and its place until the file has changed. With the
// option `loop` a recording with damaged blocks is played again.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "driver_api/driver.hpp"
#include "drivers/replay/playlist.hpp"

namespace slipd::replay {

class ReplayDriver final : public DeviceDriver {
 public:
  // Throws DriverError for options that make no sense.
  explicit ReplayDriver(const std::vector<SensorSetup>& sensors);

  DeviceInfo open() override;
  ReadResult read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept override;
  void close() noexcept override {}  // the files stay open, because open() reports their faults
  bool paced_by_consumer() const noexcept override { return speed_ == 0; }

 private:
  struct Playback {
    explicit Playback(const SensorSetup& sensor);

    SensorSetup setup;
    Options options;
    std::optional<Playlist> list;
    std::filesystem::file_time_type changed;  // the file's time when it was opened
    std::vector<float> memory;
    FrameSlot staged;         // the next frame, read ahead because it holds its own due time
    std::int64_t due_ns = 0;  // when the staged frame is due
    bool is_staged = false;
    bool over = false;
    bool damaged = false;
  };

  void open_playback(Playback& playback);
  std::optional<ReadResult> stage(std::uint16_t sensor) noexcept;
  std::int64_t due_ns(std::int64_t recorded_ns) const noexcept;

  std::vector<Playback> playbacks_;
  double speed_;
  std::int64_t start_ns_ = 0;
};

}  // namespace slipd::replay
