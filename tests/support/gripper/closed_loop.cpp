#include "tests/support/gripper/closed_loop.hpp"

#include <span>

namespace slipd::gripper {
namespace {

constexpr std::uint32_t kBaseId = 0x5A0;

Settings settings_for(const ChainSetup& setup) {
  Settings settings;
  settings.sensors.push_back(
      {.setup = {.name = "finger", .layout = setup.layout, .profile = {}, .device = {}, .options = {}},
       .driver = "sim",
       .friction = {},
       .gain = {}});
  settings.alerts = setup.alerts;
  CanSettings& can = settings.can.emplace();
  can.base_id = kBaseId;
  can.allow_simulated = true;
  return settings;
}

}  // namespace

ClosedLoop::ClosedLoop(const sim::SensorSettings& sensor, const GripperSettings& gripper,
                       const ChainSetup& setup, bool listening)
    : settings_(settings_for(setup)),
      status_(add_sensor()),
      scheduler_(settings_, board_, bus_, log_, now_),
      sensor_(setup.layout, sensor),
      chain_(setup, nullptr),
      memory_(3 * setup.layout.size()),
      grip_input_(folder_.file("grip").string()),
      grip_output_(folder_.file("grip").string()),
      receiver_(kBaseId, 0, settings_.can->period),
      controller_(gripper, now_),
      listening_(listening) {
  const std::span all(memory_);
  const std::size_t taxels = setup.layout.size();
  slot_.normal_pa = all.first(taxels);
  slot_.shear_x_pa = all.subspan(taxels, taxels);
  slot_.shear_y_pa = all.last(taxels);
}

void ClosedLoop::step() {
  now_ += kFrame;
  force_n_ = controller_.step(receiver_, now_);
  grip_output_.press(force_n_);
  if (const auto normal_n = grip_input_.newest()) sensor_.grip(normal_n);
  sensor_.advance(kFrame);
  if (!sensor_.sample(slot_) || !listening_) return;
  publish(chain_.estimate(slot_.view()));
  can_frame frame{};
  while (bus_.next(frame)) receiver_.receive(frame, now_);
}

SensorStatus& ClosedLoop::add_sensor() {
  SensorStatus& status = *board_.sensors.emplace_back(std::make_unique<SensorStatus>("finger", "sim"));
  status.simulated = true;
  status.link = DeviceLink::open;
  return status;
}

// The estimate thread's work; then the CAN thread's, if a message is due or the doorbell has rung.
void ClosedLoop::publish(Estimate estimate) noexcept {
  estimate.published_ns = std::chrono::nanoseconds(now_.time_since_epoch()).count();
  Published reading = status_.latest.load();
  const bool rings = estimate.alert != reading.estimate.alert || estimate.state != reading.estimate.state;
  reading.estimate = estimate;
  status_.latest.store(reading);
  if (rings || now_ >= due_) due_ = scheduler_.step(now_);
}

}  // namespace slipd::gripper
