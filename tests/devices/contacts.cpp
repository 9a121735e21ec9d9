#include "tests/devices/contacts.hpp"

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

#include "drivers/sim/options.hpp"

namespace slipd::devices {
namespace {

constexpr double kWeightNoiseN = 0.02;  // of the sum over a pad

}  // namespace

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

std::vector<Contact> weights(const DeviceModel& model, const std::filesystem::path& file) {
  struct Load {
    double x_n = 0, y_n = 0, normal_n = 0, at_x_mm = 0, at_y_mm = 0;
  };
  std::vector<Contact> contacts;
  for (std::size_t sensor = 0; sensor < model.sensors; ++sensor) {
    contacts.push_back([&model, file, random = std::mt19937(1 + sensor)](FrameSlot& slot) mutable {
      Load load;
      std::ifstream(file) >> load.x_n >> load.y_n >> load.normal_n >> load.at_x_mm >> load.at_y_mm;
      std::vector<std::size_t> under;
      for (std::size_t i = 0; i < model.layout.size(); ++i) {
        const double away_mm = std::hypot(1e3 * model.layout.x_m()[i] - load.at_x_mm,
                                          1e3 * model.layout.y_m()[i] - load.at_y_mm);
        if (away_mm < 1e3 * model.layout.side_m()) under.push_back(i);
      }
      std::normal_distribution<double> noise_n(
          0, kWeightNoiseN / std::sqrt(static_cast<double>(model.layout.size())));
      const double area_m2 = model.layout.area_m2();
      const auto fill = [&](std::span<float> values, double force_n) {
        for (float& value : values) value = static_cast<float>(noise_n(random) / area_m2);
        for (const std::size_t i : under)
          values[i] += static_cast<float>(force_n / static_cast<double>(under.size()) / area_m2);
      };
      fill(slot.normal_pa, load.normal_n);
      fill(slot.shear_x_pa, load.x_n);
      fill(slot.shear_y_pa, load.y_n);
      slot.truth = {};
    });
  }
  return contacts;
}

}  // namespace slipd::devices
