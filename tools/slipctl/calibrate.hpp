// `slipctl calibrate`: leads through a calibration with known weights, and reads the sensor meanwhile.
#pragma once

#include <string>

#include "tools/slipctl/commands.hpp"

namespace slipctl {

struct CalibrateOptions {
  std::string sensor;   // its name
  double normal_n = 0;  // force of the weight that rests on the sensor, N, > 0
  double shear_n = 0;   // force of the weight that pulls, N; 0: none does
  double seconds = 3;   // of stillness that are read in each step
  bool corner = false;  // whether the weight is put on two corners, too
  std::string step;     // only this step, without questions; empty: all
  std::string file;     // what steps have read; needed with `step`
};

// "200g", "0.2 kg" or "1.5N" as a force in N. Throws std::invalid_argument unless it is above 0 and has a
// unit.
double force_of(const std::string& text);

// Asks on stderr and goes on at each line of stdin; the result goes to stdout. Throws ClientError and
// calibration::CalibrationError.
void calibrate(const CommonOptions& common, const CalibrateOptions& options);

}  // namespace slipctl
