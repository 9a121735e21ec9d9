// Wakes the io thread from real-time threads: an eventfd that epoll watches. Between two clear() it is
// written at most once, however often notify() is called.
#pragma once

#include <atomic>

namespace slipd {

// Thread-safe between any number of notifying threads and io.
class IoWakeup {
 public:
  // Called from one thread: set-up. Throws std::system_error if there is no descriptor left.
  IoWakeup();
  ~IoWakeup();
  IoWakeup(const IoWakeup&) = delete;
  IoWakeup& operator=(const IoWakeup&) = delete;

  // The descriptor to watch for reading. It stays this object's.
  int fd() const noexcept { return fd_; }

  // Called from any thread, after it wrote what io is to find. Never blocks; at most one system call.
  void notify() noexcept;

  // Called from one thread: io, before it looks for what was written. A later notify() wakes it again.
  void clear() noexcept;

 private:
  int fd_;
  std::atomic<bool> notified_{false};
};

}  // namespace slipd
