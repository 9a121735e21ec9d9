// The options of driver `replay`, parsed from JSON that fits options.json, and the calibration of values.
#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/frame/frame.hpp"
#include "driver_api/driver.hpp"

namespace slipd::replay {

// value = (raw - bias) * scale, in Pa, or in the file's own unit where the unit is `raw`.
struct Calibration {
  std::array<float, 3> scale{1, 1, 1};  // of x, y, z; Pa per unit of the file
  std::vector<float> bias;              // x, y, z of each taxel in turn, units of the file

  // Acquire thread. False: a value is not finite, and the frame must not be used.
  bool apply(FrameSlot& frame) const noexcept;
};

struct Options {
  std::filesystem::path file;  // a recording, a CSV, or a folder of them
  double speed = 1;            // multiple of the recorded speed; 0: as fast as the estimator takes frames
  bool loop = false;           // play again from the first file at the end
  bool raw = false;            // values are counts of a sensor whose zero is not known
  Calibration calibration;     // of the file's values
  double zero_from_s = 0;      // above 0: each file's bias is the mean of its first rows of so many seconds
};

// Throws DriverError for a `scale` or `bias` whose length is neither 1, 3 nor (bias) three a taxel.
Options parse_options(const SensorSetup& sensor);

// The names of the taxels in a CSV, in the layout's order: the option `taxels`, or txl1 … txlN. Throws
// DriverError unless they are as many as the layout's taxels and all different.
std::vector<std::string> taxel_names(const SensorSetup& sensor);

}  // namespace slipd::replay
