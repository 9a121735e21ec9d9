#include "drivers/replay/replay_driver.hpp"

#include <algorithm>
#include <cmath>
#include <system_error>

#include "drivers/pacing.hpp"

namespace slipd::replay {
namespace {

std::filesystem::file_time_type change_time(const std::filesystem::path& file) {
  std::error_code none;
  return std::filesystem::last_write_time(file, none);
}

}  // namespace

ReplayDriver::Playback::Playback(const SensorSetup& sensor)
    : setup(sensor), options(parse_options(sensor)), memory(3 * sensor.layout.size()) {
  const std::size_t taxels = sensor.layout.size();
  const std::span<float> all(memory);
  staged.normal_pa = all.first(taxels);
  staged.shear_x_pa = all.subspan(taxels, taxels);
  staged.shear_y_pa = all.last(taxels);
}

ReplayDriver::ReplayDriver(const std::vector<SensorSetup>& sensors) {
  for (const auto& sensor : sensors) playbacks_.emplace_back(sensor);
  speed_ = playbacks_.front().options.speed;
  for (const auto& playback : playbacks_) {
    if (playback.options.speed != speed_) {
      throw DriverError("sensor \"" + playback.setup.name +
                        "\": replay's speed must be the same for all sensors of a device");
    }
  }
}

void ReplayDriver::open_playback(Playback& playback) {
  const auto changed = change_time(playback.options.file);
  if (playback.damaged && playback.list && changed == playback.changed) {
    throw DriverError(playback.list->fault() + " (the rest was played; repair the file or leave it out)");
  }
  playback.list.emplace(playback.setup, playback.options);
  playback.changed = changed;
  playback.is_staged = playback.over = playback.damaged = false;
  playback.due_ns = 0;
}

DeviceInfo ReplayDriver::open() {
  DeviceInfo info;
  // Recorded frames are not the gripper's present state, so no controller may act on them.
  info.simulated = true;
  for (auto& playback : playbacks_) {
    open_playback(playback);
    info.sensors.push_back({.sensor_class = playback.list->sensor_class(),
                            .layout = playback.setup.layout,
                            .rate_hz = speed_ * playback.list->rate_hz(),
                            .zeroed = playback.list->zeroed(),
                            .part = playback.options.file.string()});
    info.description += (info.description.empty() ? "replay of " : ", ") + playback.options.file.string();
    if (playback.list->files() > 1)
      info.description += " (" + std::to_string(playback.list->files()) + " files)";
  }
  start_ns_ = monotonic_ns();
  return info;
}

// Reads the sensor's next frame ahead. A result that read() must return at once, or nothing.
std::optional<ReadResult> ReplayDriver::stage(std::uint16_t sensor) noexcept {
  Playback& playback = playbacks_[sensor];
  if (playback.is_staged || playback.over) return std::nullopt;
  switch (playback.list->next(playback.staged)) {
    case ReadOutcome::frame:
      playback.is_staged = true;
      playback.due_ns = std::max(due_ns(playback.staged.time_ns), playback.due_ns + 1);
      break;
    case ReadOutcome::corrupt:
      return ReadResult{ReadStatus::corrupt, sensor};
    case ReadOutcome::none:
      return ReadResult{ReadStatus::timeout, sensor};
    case ReadOutcome::damaged:
      playback.damaged = true;
      [[fallthrough]];
    case ReadOutcome::end:
      playback.over = true;
      break;
  }
  return std::nullopt;
}

// At speed 0 time stamps keep the recorded intervals, so that estimates do not depend on the machine's speed.
std::int64_t ReplayDriver::due_ns(std::int64_t recorded_ns) const noexcept {
  if (speed_ == 0 || speed_ == 1) return start_ns_ + recorded_ns;
  return start_ns_ + std::llround(static_cast<double>(recorded_ns) / speed_);
}

ReadResult ReplayDriver::read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept {
  std::optional<std::uint16_t> first;
  std::uint16_t sensor = 0;
  for (const Playback& playback : playbacks_) {
    if (const auto result = stage(sensor)) return *result;
    if (playback.is_staged && (!first || playback.due_ns < playbacks_[*first].due_ns)) first = sensor;
    ++sensor;
  }
  if (!first) {
    const bool damaged =
        std::any_of(playbacks_.begin(), playbacks_.end(), [](const Playback& p) { return p.damaged; });
    return {damaged ? ReadStatus::disconnected : ReadStatus::end, 0};
  }
  Playback& playback = playbacks_[*first];
  const std::int64_t give_up_ns = monotonic_ns() + std::chrono::nanoseconds(timeout).count();
  if (speed_ != 0 && !sleep_until(playback.due_ns, give_up_ns)) return {ReadStatus::timeout, *first};
  FrameSlot& out = slots[*first];
  const FrameSlot& in = playback.staged;
  std::copy(in.normal_pa.begin(), in.normal_pa.end(), out.normal_pa.begin());
  std::copy(in.shear_x_pa.begin(), in.shear_x_pa.end(), out.shear_x_pa.begin());
  std::copy(in.shear_y_pa.begin(), in.shear_y_pa.end(), out.shear_y_pa.begin());
  out.sequence = in.sequence;
  out.time_ns = playback.due_ns;
  out.device_time_ns = in.device_time_ns;
  out.truth = in.truth;
  playback.is_staged = false;
  return {ReadStatus::frame, *first};
}

}  // namespace slipd::replay
