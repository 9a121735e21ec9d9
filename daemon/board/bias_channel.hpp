// What is asked and told of one sensor's zero across threads.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/bias/bias.hpp"
#include "daemon/rt/latest.hpp"

namespace slipd {

struct BiasRequest {
  std::uint32_t number = 0;  // from 1; 0: there was none
  bool force = false;
};

class BiasChannel {
 public:
  Latest<BiasReport> report;  // acquire thread writes
  // Acquire thread writes, while setting up: the device does not zero itself. Relaxed: nothing else is read
  // on its word.
  std::atomic<bool> needed{false};

  // io. A new zero is wanted; the request's number.
  std::uint32_t ask(bool force) noexcept {
    const std::uint32_t number = newest().number + 1;
    // Relaxed: nothing else is read on its word.
    wanted_.store(number << 1U | (force ? 1U : 0U), std::memory_order_relaxed);
    return number;
  }

  // Any thread: whether its frames read 0 without load.
  bool known() const noexcept {
    return !needed.load(std::memory_order_relaxed) || report.load().origin != BiasOrigin::none;
  }

  // Any thread: the newest request.
  BiasRequest newest() const noexcept {
    const std::uint32_t word = wanted_.load(std::memory_order_relaxed);
    return {word >> 1U, (word & 1U) != 0};
  }

  // Keeper of zeros: all requests up to this one are answered, and a zero that was taken is on disk if that
  // can be. Release: whoever reads it finds the report, and the trouble there was, as they were then.
  void settle(std::uint32_t request) noexcept { settled_.store(request, std::memory_order_release); }
  std::uint32_t settled() const noexcept { return settled_.load(std::memory_order_acquire); }

 private:
  std::atomic<std::uint32_t> wanted_{0}, settled_{0};
};

}  // namespace slipd
