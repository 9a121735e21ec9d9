// How a real-time thread wakes the io thread: an eventfd that epoll can watch, written at most once until io
// has looked.
#pragma once

#include <atomic>

namespace slipd {

class Wake {
 public:
  Wake();  // throws std::system_error
  ~Wake();
  Wake(const Wake&) = delete;
  Wake& operator=(const Wake&) = delete;

  int fd() const noexcept { return fd_; }

  // Any thread, after it has put its news where io looks. Never blocks.
  void ring() noexcept;

  // io, before it looks for news: so that a ring from now on is heard.
  void clear() noexcept;

 private:
  int fd_;
  std::atomic<bool> rung_{false};
};

}  // namespace slipd
