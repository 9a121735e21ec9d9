// One sensor's place in the pipeline, where its threads meet. Made before any of them, lives as long as the
// last.
#pragma once

#include <atomic>

#include "config/settings.hpp"
#include "daemon/board/board.hpp"
#include "daemon/pipeline/estimator_instance.hpp"

namespace slipd {

struct SensorRuntime {
  SensorRuntime(const SensorSettings& sensor, SensorStatus& its_status)
      : settings(sensor), status(its_status) {}

  const SensorSettings settings;
  SensorStatus& status;
  // EstimatorInstance maker → estimate: exchanged whole, release on putting and acquire on taking, so that
  // what it points to is seen.
  std::atomic<EstimatorInstance*> incoming{nullptr};
  // EstimatorInstance maker → estimate: no estimator can be had for this device as it is. Relaxed: nothing
  // else is read on its word, and the bell is rung after it.
  std::atomic<bool> refused{false};
};

}  // namespace slipd
