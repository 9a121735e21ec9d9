// Where one sensor's zero is worked at: the acquire thread takes it off each frame, and hands what is worth
// keeping to the keeper of zeros. One word says whose turn the copy between them is.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "core/bias/bias_estimator.hpp"
#include "daemon/board/bias_channel.hpp"
#include "daemon/rt/doorbell.hpp"
#include "daemon/state/bias_file.hpp"
#include "driver_api/driver.hpp"

namespace slipd {

class SensorStatus;

class BiasWorker {
 public:
  // Set-up. `panel` and `keeper` outlive it.
  BiasWorker(SensorStatus& status, const SensorInfo& sensor, BiasIdentity identity, Doorbell& store);

  const BiasIdentity& identity() const noexcept { return identity_; }
  SensorStatus& status() const noexcept { return status_; }

  // Acquire thread, while setting up. The zero of an earlier run; throws std::invalid_argument.
  void restore(const Bias& zero);
  void reopened();

  // Acquire thread. apply: before anybody else sees the frame. afterwards: when it is on its way.
  void apply(FrameSlot& frame) noexcept;
  void afterwards() noexcept;

  // Acquire thread, out of real time: no frames come for a while; gives the keeper what it has not got yet.
  void rest();

  // Keeper. The zero to be kept, or null; valid until release().
  const Bias* to_keep() const noexcept;
  void release() noexcept;                                               // it is kept
  std::uint32_t kept_takings() const noexcept { return kept_takings_; }  // BiasReport::taken, of the last one

 private:
  bool worth_keeping(std::int64_t followed_ns) const noexcept;  // it is new, or has followed for so long
  void offer() noexcept;
  void tell() noexcept;

  SensorStatus& status_;
  const BiasIdentity identity_;
  Doorbell& store_;
  BiasEstimator bias_estimator_;
  std::uint32_t offered_takings_ = 0;  // of the zero last offered
  std::int64_t offered_confirmed_ns_ = 0;
  // The copy is the keeper's: offer() releases it to to_keep(), and release() gives it back.
  std::atomic<bool> filled_{false};
  Bias copy_;
  std::uint32_t copy_takings_ = 0;
  std::uint32_t kept_takings_ = 0;  // keeper's
};

}  // namespace slipd
