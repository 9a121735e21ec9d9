// Requests and reports about one sensor's bias, between io, the acquire thread and the bias store.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/frame/latest.hpp"
#include "core/zero/bias.hpp"

namespace slipd {

// A request to measure the bias anew.
struct BiasRequest {
  // Counts requests from 1; 0: there was none.
  std::uint32_t number = 0;
  // Measure even if the sensor seems to be in contact.
  bool force = false;
};

// Thread-safe. Each member says which thread may call it.
class BiasChannel {
 public:
  // Written by one thread: acquire. Read from any thread.
  Latest<BiasReport> report;
  // Whether slipd has to subtract a bias, because the device does not. Written by one thread: acquire, while
  // it opens the device. Read from any thread. Relaxed: no other memory is read because of this value.
  std::atomic<bool> needed{false};
  // False: the device's values are no pressures, so that no bias makes them so. Written and read as `needed`.
  std::atomic<bool> possible{true};

  // Called from one thread: io. Requests a new bias and returns the request's number. The caller wakes
  // nobody: the acquire thread looks at each frame.
  std::uint32_t request(bool force) noexcept {
    const std::uint32_t number = newest_request().number + 1;
    // Relaxed: no other memory is read because of this value.
    requested_.store(number << 1U | (force ? 1U : 0U), std::memory_order_relaxed);
    return number;
  }

  // Called from any thread. Whether frames read 0 without load: the bias is known and not in doubt, or not
  // needed.
  bool known() const noexcept {
    if (!needed.load(std::memory_order_relaxed)) return true;
    const BiasReport now = report.load();
    return now.origin != BiasOrigin::none && now.doubt == BiasDoubt::none;
  }

  // Called from any thread. The newest request.
  BiasRequest newest_request() const noexcept {
    const std::uint32_t word = requested_.load(std::memory_order_relaxed);
    return {word >> 1U, (word & 1U) != 0};
  }

  // Called from one thread: bias store. All requests up to number `request` are done, and a new bias is on
  // disk unless writing failed. Release: pairs with completed().
  void complete(std::uint32_t request) noexcept { completed_.store(request, std::memory_order_release); }

  // Called from any thread. The number of the newest request that is done. Acquire: pairs with complete(), so
  // that the report and DeviceFacts::zero_trouble belong to that request or a later one.
  std::uint32_t completed() const noexcept { return completed_.load(std::memory_order_acquire); }

 private:
  std::atomic<std::uint32_t> requested_{0};  // number << 1 | force
  std::atomic<std::uint32_t> completed_{0};
};

}  // namespace slipd
