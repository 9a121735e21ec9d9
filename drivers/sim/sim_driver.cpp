#include "drivers/sim/sim_driver.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/pacing.hpp"

namespace slipd::sim {
namespace {

// Further behind than this, frames are given up: a device's buffer is not endless either.
constexpr std::int64_t kLongestLagNs = 100'000'000;

std::string size_of(const TaxelLayout& layout) {
  if (layout.size() == 1) return "force vector";
  const auto& grid = layout.regular();
  return grid ? std::to_string(grid->columns) + " x " + std::to_string(grid->rows)
              : std::to_string(layout.size()) + " taxels";
}

}  // namespace

SimDriver::SimDriver(const std::vector<SensorSetup>& sensors) {
  for (const auto& sensor : sensors) {
    if (!(sensor.rate_hz > 0) || sensor.rate_hz > 1e6) {
      throw DriverError("sensor \"" + sensor.name +
                        "\": a simulated sensor needs a rate_hz of up to 1000000 Hz");
    }
    channels_.push_back(
        {sensor, parse_options(sensor), std::llround(1e9 / sensor.rate_hz), std::nullopt, nullptr, 0, 0});
  }
  in_real_time_ = channels_.front().options.in_real_time;
  for (const auto& channel : channels_) {
    if (channel.options.in_real_time != in_real_time_) {
      throw DriverError("sensor \"" + channel.setup.name +
                        "\": a simulated sensor's speed must be the same for all sensors of a device");
    }
  }
}

DeviceInfo SimDriver::open() {
  DeviceInfo info;
  info.simulated = true;
  close();
  for (auto& channel : channels_) {
    const auto& layout = channel.setup.layout;
    channel.sensor.emplace(layout, channel.options.sensor);
    if (!channel.options.grip_input.empty())
      channel.grip = std::make_unique<GripInput>(channel.options.grip_input);
    info.sensors.push_back(
        {.sensor_class = layout.size() == 1 ? SensorClass::wrench : SensorClass::array3,
         .layout = layout,
         .rate_hz = channel.setup.rate_hz,
         .zeroed = channel.options.zeroed,
         .part = channel.setup.name + ", seed " + std::to_string(channel.options.sensor.imperfections.seed)});
    info.description += (info.description.empty() ? "simulated " : ", ") + size_of(layout);
  }
  const std::int64_t start_ns = monotonic_ns();
  for (auto& channel : channels_) {
    channel.sampled_ns = start_ns;
    channel.due_ns = start_ns;
    next_due(channel);
  }
  return info;
}

void SimDriver::close() noexcept {
  for (auto& channel : channels_) channel.grip.reset();
}

// Late frames keep their order.
void SimDriver::next_due(Channel& channel) noexcept {
  channel.sampled_ns += channel.period_ns;
  channel.due_ns = std::max(channel.sampled_ns + channel.sensor->late_ns(), channel.due_ns + 1);
}

void SimDriver::catch_up(Channel& channel, std::int64_t now_ns) noexcept {
  if (now_ns - channel.due_ns < kLongestLagNs) return;
  const std::int64_t frames = (now_ns - channel.due_ns) / channel.period_ns;
  channel.sensor->skip(static_cast<std::uint64_t>(frames));
  channel.sensor->advance(std::chrono::nanoseconds(frames * channel.period_ns));
  channel.sampled_ns += frames * channel.period_ns;
  channel.due_ns += frames * channel.period_ns;
}

ReadResult SimDriver::read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept {
  const std::int64_t give_up_ns = monotonic_ns() + std::chrono::nanoseconds(timeout).count();
  for (;;) {
    const auto first =
        std::min_element(channels_.begin(), channels_.end(),
                         [](const Channel& a, const Channel& b) { return a.due_ns < b.due_ns; });
    const auto index = static_cast<std::uint16_t>(first - channels_.begin());
    if (in_real_time_) {
      if (!sleep_until(first->due_ns, give_up_ns)) return {ReadStatus::timeout, index};
      catch_up(*first, monotonic_ns());
    }
    if (first->grip) {
      if (const auto normal_n = first->grip->newest()) first->sensor->grip(normal_n);
    }
    first->sensor->advance(std::chrono::nanoseconds(first->period_ns));
    FrameSlot& out = slots[index];
    const bool came = first->sensor->sample(out);
    if (came) out.time_ns = first->due_ns;
    next_due(*first);
    if (came) return {ReadStatus::frame, index};
  }
}

}  // namespace slipd::sim
