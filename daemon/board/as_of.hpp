// What any door may say of an estimate at the moment it is asked. The estimate thread publishes that a sensor
// is stale; when it is stuck itself, nobody does, and an old margin would pass for one of now. Any thread.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/estimate/estimate.hpp"
#include "daemon/board/board.hpp"

namespace slipd {

// now_ns: CLOCK_MONOTONIC. An estimate older than stale_after_ns is stale; its alert stands if it was raised.
// Those that are published once and hold until another replaces them have no age: stale, fault, and
// `learning` without a force, while the estimator is made.
inline Estimate as_of(std::int64_t now_ns, const Estimate& latest, std::int64_t stale_after_ns) noexcept {
  const bool holds = latest.state == State::stale || latest.state == State::fault ||
                     (latest.state == State::learning && !latest.normal_n);
  if (holds || now_ns - latest.published_ns <= stale_after_ns) return latest;
  Estimate stale;
  stale.sequence = latest.sequence;
  stale.time_ns = latest.time_ns;
  stale.published_ns = latest.published_ns;
  stale.alert = without_frames(latest.alert);
  stale.alert_cause = latest.alert_cause;
  return stale;
}

inline Published as_of(std::int64_t now_ns, const SensorStatus& status) noexcept {
  Published published = status.latest.load();
  published.estimate =
      as_of(now_ns, published.estimate, status.stale_after_ns.load(std::memory_order_relaxed));
  return published;
}

inline Estimate as_of(std::int64_t now_ns, const Board& board, const GraspStatus& grasp) noexcept {
  std::int64_t stale_after_ns = 0;
  for (const std::size_t sensor : grasp.sensors)
    stale_after_ns =
        std::max(stale_after_ns, board.sensors[sensor]->stale_after_ns.load(std::memory_order_relaxed));
  return as_of(now_ns, grasp.latest.load(), stale_after_ns);
}

}  // namespace slipd
