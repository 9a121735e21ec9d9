// A thread with a name, a small stack, all signals blocked, and a join with a deadline: what std::thread
// lacks.
#pragma once

#include <pthread.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "daemon/rt/doorbell.hpp"

namespace slipd {

// Not thread-safe. Called from one thread: the owner.
class Thread {
 public:
  // No thread.
  Thread() = default;
  // Starts `body`. At most 15 characters of `name` are kept. Throws std::system_error.
  Thread(const std::string& name, std::size_t stack_bytes, std::function<void()> body);
  Thread(Thread&& other) noexcept;
  Thread& operator=(Thread&& other) noexcept;
  // Joins, without a deadline.
  ~Thread();

  // Joins until `deadline`. False: the thread still runs; it is detached, and all that it uses must outlive
  // it. True at once if there is no thread.
  bool join_until(std::chrono::steady_clock::time_point deadline);

 private:
  pthread_t id_{};
  bool joinable_ = false;
  std::shared_ptr<Doorbell> ended_;  // rung by the thread as its last action
};

}  // namespace slipd
