// What a sensor's frames run through once its device is known: a FrameFeed, which acquire fills and estimate
// empties, and a EstimatorInstance, the FrameFeed with an estimator made for it. Both are made by set-up
// threads and handed over whole.
#pragma once

#include <atomic>
#include <memory>

#include "config/settings.hpp"
#include "core/estimate/chain.hpp"
#include "core/frame/mailbox.hpp"
#include "core/model/work_precision.hpp"
#include "daemon/rt/doorbell.hpp"
#include "driver_api/driver.hpp"

namespace slipd {

struct FrameFeed {
  FrameFeed(const SensorInfo& sensor, bool wait_for_taker)
      : info(sensor), mailbox(sensor.layout.size()), paced(wait_for_taker) {}

  const SensorInfo info;
  FrameMailbox mailbox;
  const bool paced;  // the driver waits until a frame was taken instead of replacing it
  Doorbell taken;    // estimate rings it, if paced
};

struct EstimatorInstance {
  EstimatorInstance(std::size_t of_sensor, std::shared_ptr<FrameFeed> from, ChainSetup made_for,
                    EstimatorChain with)
      : sensor(of_sensor),
        feed(std::move(from)),
        setup(std::move(made_for)),
        chain(std::move(with)),
        method(chain.method()),
        work_precision(chain.tradeoff()) {}

  const std::size_t sensor;  // on the board
  const std::shared_ptr<FrameFeed> feed;
  const ChainSetup setup;  // that its estimator was made for
  EstimatorChain chain;
  const Method method;
  const WorkPrecision work_precision;  // known when it was made, see EstimatorChain::tradeoff
  // No longer in use: the estimate thread says so with release (take_instance), the maker asks with acquire
  // before it frees it (free_retired).
  std::atomic<bool> retired{false};
};

// What a sensor's estimator has learnt of the contact that it is in, while the configuration is exchanged.
struct LearnedState {
  SensorSettings sensor;  // as it was configured
  ChainSetup setup;
  EstimatorChain chain;
};

}  // namespace slipd
