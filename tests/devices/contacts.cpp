#include "tests/devices/contacts.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "drivers/sim/options.hpp"

namespace slipd::devices {

std::vector<Contact> scripted(const DeviceModel& model, double rate_hz, const nlohmann::json& options) {
  const std::chrono::nanoseconds period(std::llround(1e9 / rate_hz));
  std::vector<Contact> contacts;
  for (std::size_t sensor = 0; sensor < model.sensors; ++sensor) {
    const SensorSetup setup{.name = std::string(model.name),
                            .layout = model.layout,
                            .rate_hz = rate_hz,
                            .profile = {},
                            .device = {},
                            .options = options};
    sim::SensorSettings settings = sim::parse_options(setup).sensor;
    settings.imperfections.seed += sensor;
    const auto sensed = std::make_shared<sim::SimulatedSensor>(model.layout, settings);
    contacts.push_back([sensed, period](FrameSlot& slot) {
      sensed->advance(period);
      sensed->sample(slot);
    });
  }
  return contacts;
}

std::vector<Contact> pattern(const DeviceModel& model) {
  std::vector<Contact> contacts;
  for (std::size_t sensor = 0; sensor < model.sensors; ++sensor) {
    contacts.push_back([sensor](FrameSlot& slot) {
      for (std::size_t i = 0; i < slot.normal_pa.size(); ++i) {
        slot.normal_pa[i] = 1000 * static_cast<float>(i + 1) + 100 * static_cast<float>(sensor);
        slot.shear_x_pa[i] = slot.normal_pa[i] / 2;
        slot.shear_y_pa[i] = -slot.normal_pa[i] / 4;
      }
      slot.truth = {};
    });
  }
  return contacts;
}

}  // namespace slipd::devices
