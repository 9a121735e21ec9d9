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

ReplayDriver::Player::Player(const SensorSetup& sensor)
    : setup(sensor), options(parse_options(sensor)), memory(3 * sensor.layout.size()) {
  const std::size_t taxels = sensor.layout.size();
  const std::span<float> all(memory);
  staged.normal_pa = all.first(taxels);
  staged.shear_x_pa = all.subspan(taxels, taxels);
  staged.shear_y_pa = all.last(taxels);
}

ReplayDriver::ReplayDriver(const std::vector<SensorSetup>& sensors) {
  for (const auto& sensor : sensors) players_.emplace_back(sensor);
  speed_ = players_.front().options.speed;
  for (const auto& player : players_) {
    if (player.options.speed != speed_) {
      throw DriverError("sensor \"" + player.setup.name +
                        "\": replay's speed must be the same for all sensors of a device");
    }
  }
}

void ReplayDriver::open_player(Player& player) {
  const auto changed = change_time(player.options.file);
  if (player.damaged && player.list && changed == player.changed) {
    throw DriverError(player.list->fault() + " (played up to there; repair the file or leave it out)");
  }
  player.list.emplace(player.setup, player.options);
  player.changed = changed;
  player.is_staged = player.over = player.damaged = false;
  player.due_ns = 0;
}

DeviceInfo ReplayDriver::open() {
  DeviceInfo info;
  // Not what a gripper feels now, so nothing that acts on it may take it for that.
  info.simulated = true;
  for (auto& player : players_) {
    open_player(player);
    info.sensors.push_back({.sensor_class = player.list->sensor_class(),
                            .layout = player.setup.layout,
                            .rate_hz = speed_ * player.list->rate_hz(),
                            .zeroed = player.list->zeroed(),
                            .part = player.options.file.string()});
    info.description += (info.description.empty() ? "replay of " : ", ") + player.options.file.string();
    if (player.list->files() > 1) info.description += " (" + std::to_string(player.list->files()) + " files)";
  }
  start_ns_ = monotonic_ns();
  return info;
}

// Reads ahead. A result to hand out at once, or nothing.
std::optional<ReadResult> ReplayDriver::stage(std::uint16_t sensor) noexcept {
  Player& player = players_[sensor];
  if (player.is_staged || player.over) return std::nullopt;
  switch (player.list->next(player.staged)) {
    case Next::frame:
      player.is_staged = true;
      player.due_ns = std::max(due_ns(player.staged.time_ns), player.due_ns + 1);
      break;
    case Next::corrupt:
      return ReadResult{ReadStatus::corrupt, sensor};
    case Next::damaged:
      player.damaged = true;
      [[fallthrough]];
    case Next::end:
      player.over = true;
      break;
  }
  return std::nullopt;
}

// As fast as it goes, time stamps keep the recorded distances: what an estimator makes of time is then the
// same on any machine.
std::int64_t ReplayDriver::due_ns(std::int64_t recorded_ns) const noexcept {
  if (speed_ == 0 || speed_ == 1) return start_ns_ + recorded_ns;
  return start_ns_ + std::llround(static_cast<double>(recorded_ns) / speed_);
}

ReadResult ReplayDriver::read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept {
  std::optional<std::uint16_t> first;
  std::uint16_t sensor = 0;
  for (const Player& player : players_) {
    if (const auto result = stage(sensor)) return *result;
    if (player.is_staged && (!first || player.due_ns < players_[*first].due_ns)) first = sensor;
    ++sensor;
  }
  if (!first) {
    const bool damaged =
        std::any_of(players_.begin(), players_.end(), [](const Player& p) { return p.damaged; });
    return {damaged ? ReadStatus::disconnected : ReadStatus::end, 0};
  }
  Player& player = players_[*first];
  const std::int64_t give_up_ns = monotonic_ns() + std::chrono::nanoseconds(timeout).count();
  if (speed_ != 0 && !sleep_until(player.due_ns, give_up_ns)) return {ReadStatus::timeout, *first};
  FrameSlot& out = slots[*first];
  const FrameSlot& in = player.staged;
  std::copy(in.normal_pa.begin(), in.normal_pa.end(), out.normal_pa.begin());
  std::copy(in.shear_x_pa.begin(), in.shear_x_pa.end(), out.shear_x_pa.begin());
  std::copy(in.shear_y_pa.begin(), in.shear_y_pa.end(), out.shear_y_pa.begin());
  out.sequence = in.sequence;
  out.time_ns = player.due_ns;
  out.device_time_ns = in.device_time_ns;
  out.truth = in.truth;
  player.is_staged = false;
  return {ReadStatus::frame, *first};
}

}  // namespace slipd::replay
