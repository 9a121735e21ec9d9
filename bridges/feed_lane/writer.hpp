// Sends one sensor's frames to slipd, in a thread of its own: slipd may be away, or answer late, and no
// source waits for it. Frames that slipd does not take in time are dropped, the oldest first.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <slipd.hpp>
#include <string>
#include <thread>
#include <vector>

namespace slipd::feed {

struct Frame {
  std::vector<float> values;   // taxels x axes
  std::int64_t time_ns = 0;    // of the sample, CLOCK_MONOTONIC
  std::uint64_t sequence = 0;  // rises; a jump by n is n - 1 lost frames
};

class Writer {
 public:
  // `socket`: slipd's, as in slipd.h. Throws client::Error for frames that no sensor has.
  Writer(const std::string& sensor, const slipd_frames& frames, const std::string& socket);
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  // Any one thread. Does not wait.
  void put(Frame frame);
  // Frames that slipd took, and those that it did not. Any thread.
  std::uint64_t sent() const noexcept { return sent_.load(std::memory_order_relaxed); }
  std::uint64_t unsent() const noexcept { return unsent_.load(std::memory_order_relaxed); }
  // Why slipd took none the last time; empty: it took it. Any thread.
  std::string trouble() const;

 private:
  void run();
  bool take(Frame& out);
  void send(const Frame& frame);
  void say(std::string trouble);

  client::Source source_;
  mutable std::mutex mutex_;
  std::condition_variable come_;
  std::deque<Frame> waiting_;  // by mutex_, as the next two
  bool ending_ = false;
  std::string trouble_;
  // Relaxed: counts for people; no other memory is read because of them.
  std::atomic<std::uint64_t> sent_{0}, unsent_{0};
  std::thread thread_;
};

}  // namespace slipd::feed
