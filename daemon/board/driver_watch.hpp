// Tells a driver that hangs from one that has nothing to say. The acquire thread that is stuck in it cannot,
// so it leaves a time here before it calls the driver, and others look whether that has passed.
#pragma once

#include <atomic>
#include <cstdint>

namespace slipd {

class DriverWatch {
 public:
  enum class Call : std::uint8_t { open, read };

  // Called from one thread: acquire. due_ns: when the call should have returned by far, CLOCK_MONOTONIC.
  void enter(Call call, std::int64_t due_ns) noexcept {
    due_ns_.store(call == Call::open ? -due_ns : due_ns, std::memory_order_relaxed);
  }
  // Called from one thread: acquire. It is in no call.
  void leave() noexcept { due_ns_.store(0, std::memory_order_relaxed); }

  // Called from any thread. That the driver hangs, for people; null: it does not. now_ns: CLOCK_MONOTONIC.
  const char* trouble(std::int64_t now_ns) const noexcept {
    const std::int64_t due_ns = due_ns_.load(std::memory_order_relaxed);
    if (due_ns > 0 && now_ns > due_ns)
      return "its driver does not return from read: plug the device in again; if that does not help, restart "
             "slipd";
    if (due_ns < 0 && now_ns > -due_ns)
      return "its driver does not return from open: plug the device in again; if that does not help, restart "
             "slipd";
    return nullptr;
  }

 private:
  // Negative: in open; 0: in no call. Both in one value, so that no reader takes the time of one call for
  // that of the other. Relaxed: no other memory is read because of it.
  std::atomic<std::int64_t> due_ns_{0};
};

}  // namespace slipd
