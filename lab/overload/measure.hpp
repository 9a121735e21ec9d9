// What skipped frames do to an estimator: the whole chain over random grasps, of which it gets only some of
// the frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/chain/chain.hpp"
#include "lab/histories/drive.hpp"
#include "lab/overload/skipping.hpp"
#include "paper/model/model.hpp"

namespace lab {

struct OverloadCase {
  Skipping skipping = Skipping::regular;
  unsigned k = 1;  // the sensor's frames for one that comes
};

struct OverloadLine {
  std::size_t columns = 0;  // taxels along each side of the pad
  std::string method;
  OverloadCase skipped;
  ErrorStatistics estimates;  // of the frames that came
  ErrorStatistics board;      // at every frame of the sensor: what the last estimate says of the margin now
};

struct OverloadSetup {
  std::size_t grasps = 50;  // of each line
  Sampling sensing;         // of the sensor, all of whose frames are on time
  std::uint64_t seed = 1;
  unsigned threads = 2;
};

// `chain`: what the estimator is made of; `model` may be null where needs_model says no.
OverloadLine measure_overload(const slipd::ChainSetup& chain,
                              const std::shared_ptr<const slipd::Model>& model, const OverloadCase& skipped,
                              const OverloadSetup& setup, const std::function<void(double)>& done = {});

}  // namespace lab
