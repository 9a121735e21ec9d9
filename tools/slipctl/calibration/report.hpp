// Scales as text for the person who edits the configuration or the profile, and as JSON. Any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/slipctl/calibration/scales.hpp"

namespace slipctl::calibration {

// Of whom the report speaks.
struct Subject {
  std::string sensor;  // its name
  std::string driver;  // which decides where scales are written
  Pad pad;
  bool zeroed = true;  // whether slipd knows its zero; never of one that is not calibrated
};

// Factors with standard deviations, what is wrong, the lines to write and where, and what is not known.
std::string report(const Subject& subject, const Weights& weights, const Scales& scales);

// {"sensor", "normal": {"factor", "sigma", "read_on", "beside"}, "shear_x", "shear_y", "gain", "layout"};
// null: not known.
nlohmann::ordered_json to_json(const Subject& subject, const Scales& scales);

}  // namespace slipctl::calibration
