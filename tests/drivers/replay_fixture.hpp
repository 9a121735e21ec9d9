// Plays a sensor's file to its end, or to its first fault.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

#include "drivers/replay/replay_driver.hpp"
#include "tests/drivers/driver_fixture.hpp"

namespace slipd::test {

struct Played {
  std::vector<FrameSlot> frames;           // without their values
  std::vector<std::vector<float>> values;  // normal, shear x, shear y
  int corrupt = 0;
  ReadStatus last = ReadStatus::frame;
};

inline Played play(DeviceDriver& driver, std::size_t taxels, std::size_t at_most = 100000) {
  Played played;
  OwnedSlot slot(taxels);
  while (played.frames.size() < at_most) {
    const auto result = driver.read({&slot.slot, 1}, std::chrono::seconds(1));
    played.last = result.status;
    if (result.status == ReadStatus::corrupt) ++played.corrupt;
    if (result.status == ReadStatus::end || result.status == ReadStatus::disconnected) break;
    if (result.status != ReadStatus::frame) continue;
    played.frames.push_back(slot.slot);
    played.values.push_back(slot.memory);
  }
  return played;
}

inline Played play_whole(const SensorSetup& sensor) {
  replay::ReplayDriver driver({sensor});
  driver.open();
  return play(driver, sensor.layout.size());
}

// What opening it says; empty if it opens.
inline std::string opening(const SensorSetup& sensor) {
  return refusal_of([&] { replay::ReplayDriver({sensor}).open(); });
}

}  // namespace slipd::test
