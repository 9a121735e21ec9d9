// Shared by the tests of drivers: slots with memory, and a setup of one sensor.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "driver_api/driver.hpp"

namespace slipd::test {

// A slot that owns its memory.
struct OwnedSlot {
  explicit OwnedSlot(std::size_t taxels) : memory(3 * taxels) {
    slot.normal_pa = std::span(memory).first(taxels);
    slot.shear_x_pa = std::span(memory).subspan(taxels, taxels);
    slot.shear_y_pa = std::span(memory).last(taxels);
  }
  std::vector<float> memory;
  FrameSlot slot;
};

inline SensorSetup setup_of(TaxelLayout layout, nlohmann::json options, double rate_hz = 1000) {
  return {.name = "left",
          .layout = std::move(layout),
          .rate_hz = rate_hz,
          .profile = {},
          .device = nlohmann::json::object(),
          .options = std::move(options)};
}

// The text of the DriverError that `action` throws; empty if it throws none.
template <class Action>
std::string refusal_of(Action action) {
  try {
    action();
  } catch (const DriverError& e) {
    return e.what();
  }
  return {};
}

}  // namespace slipd::test
