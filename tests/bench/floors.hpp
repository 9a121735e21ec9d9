// What slipd's hand-overs cost at least on this machine: the same threads, sockets and rates with nothing to
// do in them. Goals on the daemon's times are ratios to these, taken in the same run. Each call starts its
// own threads and joins them.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

#include "tests/bench/times.hpp"

namespace slipd::bench {

// Throws std::system_error of errno; `what` names the call that failed.
[[noreturn]] void fail(const char* what);

// One thread wakes another by a futex, and is woken by it: half of such a turn.
Quantiles futex_wake(std::chrono::milliseconds long_enough);

// A frame of 100 x 100 is copied, a second thread is woken, which copies the frame again and wakes the first.
Quantiles frame_there_and_back(std::chrono::milliseconds long_enough);

// The way of a frame of 100 x 100 at 1 kHz: a device's thread copies it and stamps it, wakes by a futex a
// second thread, which copies it and wakes by an eventfd a third, which sends 300 bytes to a client that
// waits on a Unix socket. From the stamp until the client has them.
Quantiles frame_to_client(std::chrono::milliseconds long_enough);

// Share of a core that two threads take, one of which wakes at 1 kHz by the clock and the other by a futex
// each time.
double two_threads_at_1_khz(std::chrono::milliseconds long_enough);

// A server on a Unix socket, one thread, epoll: sends `answer_bytes`, the last a newline, for each request
// that it reads.
class EchoServer {
 public:
  EchoServer(const std::filesystem::path& socket, std::size_t answer_bytes);  // throws std::system_error
  ~EchoServer();
  EchoServer(const EchoServer&) = delete;
  EchoServer& operator=(const EchoServer&) = delete;

 private:
  void serve() const;
  std::string answer_;
  int listening_ = -1, events_ = -1, stop_ = -1;
  std::thread thread_;
};

}  // namespace slipd::bench
