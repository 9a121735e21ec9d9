// What a sensor's frames pass through once its device is open: a FrameFeed from acquire to estimate, and an
// EstimatorInstance, which is the feed with its estimator. Threads that set up make both; they are complete
// before another thread sees them.
#pragma once

#include <atomic>
#include <memory>

#include "config/settings.hpp"
#include "core/chain/chain.hpp"
#include "core/frame/mailbox.hpp"
#include "core/reading/method/work_precision.hpp"
#include "daemon/rt/doorbell.hpp"
#include "driver_api/driver.hpp"

namespace slipd {

// The frames of one sensor. Shared by acquire and estimate; const members never change.
struct FrameFeed {
  FrameFeed(const SensorInfo& sensor, bool wait_for_consumer)
      : info(sensor), mailbox(sensor.layout.size()), paced(wait_for_consumer) {}

  // The sensor, as its driver described it.
  const SensorInfo info;
  // From acquire to estimate.
  FrameMailbox mailbox;
  // Whether the driver waits until a frame was taken instead of replacing it.
  const bool paced;
  // If paced, rung by estimate after it took a frame; acquire waits on it.
  Doorbell taken;
};

// A sensor's estimator. Made by set-up, used by estimate until it is retired, freed by set-up.
struct EstimatorInstance {
  EstimatorInstance(std::size_t of_sensor, std::shared_ptr<FrameFeed> from, ChainSetup made_for,
                    EstimatorChain with)
      : sensor(of_sensor),
        feed(std::move(from)),
        setup(std::move(made_for)),
        chain(std::move(with)),
        method(chain.method()),
        work_precision(chain.tradeoff()) {}

  // Index into Board::sensors.
  const std::size_t sensor;
  // Where its frames come from.
  const std::shared_ptr<FrameFeed> feed;
  // What the chain was made for.
  const ChainSetup setup;
  // Used by one thread: estimate. By io after that thread ended.
  EstimatorChain chain;
  // The chain's method.
  const Method method;
  // Error against run time, if it was known when the chain was made; else without rows.
  const WorkPrecision work_precision;
  // No longer used by estimate. Written with release by EstimateLoop::adopt_instance, read with acquire by
  // EstimatorFactory::free_retired, which then frees it.
  std::atomic<bool> retired{false};
};

// A sensor's estimator with what it has learned of the present grasp, handed from one configuration to the
// next.
struct LearnedState {
  // The sensor as it was configured.
  SensorSettings sensor;
  // What the chain was made for.
  ChainSetup setup;
  // The estimator.
  EstimatorChain chain;
};

}  // namespace slipd
