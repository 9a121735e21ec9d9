// One sensor's place in the pipeline, where its threads meet. Made before any of them, lives as long as the
// last.
#pragma once

#include <atomic>

#include "config/settings.hpp"
#include "daemon/board/board.hpp"
#include "daemon/pipeline/estimator_instance.hpp"

namespace slipd {

struct Seat {
  Seat(const SensorSettings& sensor, Panel& its_panel) : settings(sensor), panel(its_panel) {}

  const SensorSettings settings;
  Panel& panel;
  // Lane maker → estimate: exchanged whole, release on putting and acquire on taking, so that what it points
  // to is seen.
  std::atomic<Lane*> incoming{nullptr};
  // Lane maker → estimate: no estimator can be had for this device as it is. Relaxed: nothing else is read on
  // its word, and the bell is rung after it.
  std::atomic<bool> refused{false};
};

}  // namespace slipd
