// The options of `replay`, out of the JSON that options.json has checked, and what they do to a frame's
// values.
#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "core/frame/frame.hpp"
#include "driver_api/driver.hpp"

namespace slipd::replay {

// value = (raw - bias) * scale, in Pa.
struct Calibration {
  std::array<float, 3> scale{1, 1, 1};  // x, y, z
  std::vector<float> bias;              // x, y, z of each taxel in turn

  // Acquire thread. False if a value is not finite afterwards: the frame is then not to be used.
  bool apply(FrameSlot& frame) const noexcept;
};

struct Options {
  std::filesystem::path file;
  double speed = 1;  // 0: as fast as it goes
  bool loop = false;
  Calibration calibration;
};

// Throws DriverError for a `scale` or `bias` whose length is neither 1, 3 nor (bias) three a taxel.
Options parse_options(const SensorSetup& sensor);

}  // namespace slipd::replay
