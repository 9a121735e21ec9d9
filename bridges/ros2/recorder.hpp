// The MCAP file that a running bridge writes beside publishing. Any thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "bridges/ros2/mcap/mcap_writer.hpp"
#include "bridges/ros2/messages/cdr.hpp"

namespace slipd::ros2 {

class Recorder {
 public:
  // Empty `file`: records nothing. A file that exists is left, and one with a number behind its name is made.
  // Throws McapError.
  explicit Recorder(const std::string& file);
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // Whether there is a recording now.
  bool records() const noexcept { return records_.load(std::memory_order_relaxed); }
  // The channel of a topic, which may have been added before.
  template <Message T>
  std::uint16_t channel(std::string_view topic) {
    return channel(topic, definitions_of<T>(), T::kTypeHash);
  }
  // Writes a message. The first error, as of a full disk, is logged and ends the recording.
  template <Message T>
  void write(std::uint16_t channel, std::int64_t realtime_ns, const T& message) {
    const std::lock_guard lock(mutex_);
    if (!writer_) return;
    encode(message, bytes_);
    append(channel, realtime_ns);
  }

 private:
  std::uint16_t channel(std::string_view topic, const std::vector<Definition>& definitions,
                        std::string_view hash);
  void append(std::uint16_t channel, std::int64_t realtime_ns);
  void fail(const std::exception& error);

  std::atomic<bool> records_{false};  // relaxed: mutex_ guards the rest
  std::mutex mutex_;
  std::unique_ptr<McapWriter> writer_;
  std::vector<std::uint8_t> bytes_;
  std::vector<std::string> topics_;  // by channel
};

}  // namespace slipd::ros2
