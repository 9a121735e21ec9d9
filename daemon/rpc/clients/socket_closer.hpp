// Closes clients' sockets where nothing waits for it. What a client sent and slipd did not read may bear
// descriptors. slipd may be the last to hold the files behind them, and then it closes these with the socket:
// the client decides how long that takes (TCP with SO_LINGER, a file system in user space). A socket with
// nothing unread, or to which the kernel lets nobody pass descriptors, is closed at once, any other one by a
// thread of its own, which no reload or stop waits for.
#pragma once

#include <atomic>
#include <memory>

#include "core/storage/unique_fd.hpp"

namespace slipd {

// Not thread-safe. Called from one thread: io.
class SocketCloser {
 public:
  // Ends the connection, and closes `socket` or hands it to a thread. False: all threads are taken, or there
  // is no memory for one; the caller keeps `socket` and tries again later.
  bool close(UniqueFd& socket) noexcept;

 private:
  // Threads that close. Written by io and by the threads, which may outlive this object. Relaxed: a counter.
  std::shared_ptr<std::atomic<int>> closing_ = std::make_shared<std::atomic<int>>(0);
};

}  // namespace slipd
