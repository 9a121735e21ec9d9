// A thread with a name, a stack of its own small size, no signals, and a join that gives up: what std::thread
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

class Thread {
 public:
  Thread() = default;
  // Starts `body`. `name`: at most 15 characters are kept. Throws std::system_error.
  Thread(const std::string& name, std::size_t stack_bytes, std::function<void()> body);
  Thread(Thread&& other) noexcept;
  Thread& operator=(Thread&& other) noexcept;
  ~Thread();  // joins, however long that takes

  // Waits for its end until `deadline`. False: it still runs, and is no longer joined by anybody (whatever it
  // uses must then outlive it).
  bool join_until(std::chrono::steady_clock::time_point deadline);

 private:
  pthread_t id_{};
  bool joinable_ = false;
  std::shared_ptr<Doorbell> ended_;  // rung by its last words
};

}  // namespace slipd
