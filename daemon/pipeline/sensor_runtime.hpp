// What the pipeline's threads share about one sensor. Made before they start, destroyed after they ended.
#pragma once

#include <atomic>

#include "config/settings.hpp"
#include "daemon/board/board.hpp"
#include "daemon/pipeline/estimator_instance.hpp"

namespace slipd {

// Thread-safe; each member names its users.
struct SensorRuntime {
  SensorRuntime(const SensorSettings& sensor, SensorStatus& its_status)
      : settings(sensor), status(its_status) {}

  // As configured. Any thread.
  const SensorSettings settings;
  // The sensor on the board. Any thread.
  SensorStatus& status;
  // A new estimator, from set-up to estimate; null: none is waiting. Exchanged with acquire and release, so
  // that the pointed-to object is seen whole.
  std::atomic<EstimatorInstance*> incoming{nullptr};
  // Whether no estimator can be made for this device. Written by set-up, read by estimate. Relaxed: no other
  // memory is read because of this value, and the doorbell is rung after it.
  std::atomic<bool> refused{false};
};

}  // namespace slipd
