// One sensor's bias in the acquire thread: subtracted from each frame, followed, and handed to the bias store
// when it is to be saved. One copy of the bias is shared; an atomic flag decides who owns it.
//
//   acquire                          filled_   store
//   hand_to_store                     false
//     writes copy_
//     store(true, release)  ------->  true
//   hand_to_store: returns                     pending_save: load(acquire), reads copy_, writes the file
//                                     false <- save_done: store(false, release)
//   hand_to_store: load(acquire),
//     writes copy_
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "core/zero/bias_estimator.hpp"
#include "daemon/board/bias_channel.hpp"
#include "daemon/rt/doorbell.hpp"
#include "daemon/state/bias_file.hpp"
#include "driver_api/driver.hpp"

namespace slipd {

class SensorStatus;

// Thread-safe between the acquire thread and the bias store.
class BiasWorker {
 public:
  // Called from one thread: acquire, out of real time. `status` and `store`, the store's doorbell, outlive
  // it.
  BiasWorker(SensorStatus& status, const SensorInfo& sensor, BiasIdentity identity, Doorbell& store);

  // Called from any thread.
  const BiasIdentity& identity() const noexcept { return identity_; }
  SensorStatus& status() const noexcept { return status_; }

  // Called from one thread: acquire, out of real time. Starts with a saved bias. Throws std::invalid_argument
  // if its size does not fit.
  void restore(const Bias& zero);
  // Called from one thread: acquire, out of real time. The same device was opened again.
  void device_reopened();

  // Called from one thread: acquire. Subtracts the bias and takes up a new request. Before the frame is
  // published. Wait-free, allocates nothing.
  void apply(FrameSlot& frame) noexcept;
  // Called from one thread: acquire, after the frame was published. Updates the bias from whole blocks of
  // frames, and hands it to the store when it is to be saved. Wait-free, allocates nothing.
  void after_publish() noexcept;

  // Called from one thread: acquire, out of real time, when the device was closed. Hands an unsaved bias to
  // the store; waits up to a second for the one before. `last`: it is not opened again, so that what the
  // sensor reads now is saved with it.
  void flush_to_store(bool last);

  // Called from one thread: bias store. The bias to save, or null. Valid until save_done().
  const Bias* pending_save() const noexcept;
  // Called from one thread: bias store. Writing the pending bias has ended, with or without success.
  void save_done() noexcept;
  // Called from one thread: bias store. BiasReport::taken of the bias last saved; 0: none was.
  std::uint32_t saved_taken() const noexcept { return saved_taken_; }
  // Called from one thread: bias store. The doubt that was last written to the log and to the facts.
  BiasDoubt& logged_doubt() noexcept { return logged_doubt_; }

 private:
  // Whether the bias was measured anew since it was handed over, or was followed for this long.
  bool should_save(std::int64_t followed_ns) const noexcept;
  // `last_pa`: see Bias. Allocates nothing.
  void hand_to_store(std::vector<float> last_pa = {}) noexcept;
  void publish_report() noexcept;

  SensorStatus& status_;
  const BiasIdentity identity_;
  Doorbell& store_;
  BiasEstimator bias_estimator_;
  std::uint32_t handed_taken_ = 0;  // BiasReport::taken of the bias last handed over
  std::int64_t handed_confirmed_ns_ = 0;
  // Whether copy_ and copy_taken_ belong to the store.
  std::atomic<bool> filled_{false};
  Bias copy_;
  std::uint32_t copy_taken_ = 0;
  std::uint32_t saved_taken_ = 0;                // the store's
  BiasDoubt logged_doubt_ = BiasDoubt::none;     // the store's
  BiasDoubt published_doubt_ = BiasDoubt::none;  // acquire's
};

}  // namespace slipd
