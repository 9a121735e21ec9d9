// What a sensor's frames run through once its device is known: a Feed, which acquire fills and estimate
// empties, and a Lane, the Feed with an estimator made for it. Both are made by set-up threads and handed
// over whole.
#pragma once

#include <atomic>
#include <memory>

#include "core/estimate/chain.hpp"
#include "core/frame/mailbox.hpp"
#include "daemon/pipeline/doorbell.hpp"
#include "drivers/driver.hpp"

namespace slipd {

struct Feed {
  Feed(const SensorInfo& sensor, bool wait_for_taker)
      : info(sensor), mailbox(sensor.layout.size()), paced(wait_for_taker) {}

  const SensorInfo info;
  FrameMailbox mailbox;
  const bool paced;  // the driver waits until a frame was taken instead of replacing it
  Doorbell taken;    // estimate rings it, if paced
};

struct Lane {
  Lane(std::shared_ptr<Feed> from, EstimatorChain with) : feed(std::move(from)), chain(std::move(with)) {}

  const std::shared_ptr<Feed> feed;
  EstimatorChain chain;
  std::atomic<bool> retired{false};  // estimate thread: no longer in use, may be freed by the maker
};

}  // namespace slipd
