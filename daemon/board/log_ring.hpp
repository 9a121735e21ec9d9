// Log lines from a thread that must not print them: each such thread has a ring of its own, io empties and
// prints it.
#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>

namespace slipd {

enum class LogLevel : std::uint8_t { debug, info, warning, error };

struct LogLine {
  LogLevel level = LogLevel::info;
  char text[243] = {};  // ended by 0, cut if longer
};

class LogRing {
 public:
  // The ring's own thread. Formats as printf into fixed memory; a line for which there is no room is counted
  // instead.
  __attribute__((format(printf, 3, 4))) void write(LogLevel level, const char* format, ...) noexcept;

  // io. False if there is none.
  bool read(LogLine& line) { return lines_.pop(line); }
  std::uint64_t take_lost() noexcept { return lost_.exchange(0, std::memory_order_relaxed); }

 private:
  boost::lockfree::spsc_queue<LogLine, boost::lockfree::capacity<64>> lines_;
  std::atomic<std::uint64_t> lost_{0};  // relaxed: a number of its own
};

}  // namespace slipd
