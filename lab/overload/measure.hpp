// What skipped frames do to an estimator: the whole chain over random grasps, of which it gets only some of
// the frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "lab/collect.hpp"
#include "lab/estimator.hpp"
#include "lab/frames/random_frames.hpp"
#include "lab/overload/skipping.hpp"
#include "lab/tally/tally.hpp"

namespace lab {

struct OverloadCase {
  Skipping skipping = Skipping::regular;
  unsigned k = 1;  // the sensor's frames for one that comes
};

struct OverloadLine {
  std::size_t columns = 0;  // taxels along each side of the pad
  std::string method;
  OverloadCase skipped;
  Tally estimates;  // of the frames that came
  Tally board;      // at every frame of the sensor: what the last estimate says of the margin now
};

struct OverloadSetup {
  std::size_t grasps = 50;  // of each line
  Sampling sensing;         // of the sensor, all of whose frames are on time
  std::uint64_t seed = 1;
  unsigned threads = 2;
};

OverloadLine measure_overload(const Estimator& estimator, const OverloadCase& skipped,
                              const OverloadSetup& setup, const Done& done = {});

}  // namespace lab
