// Log lines from a real-time thread: it formats them into a ring in fixed memory, and io prints them. Each
// such thread has a ring of its own.
#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <string_view>

namespace slipd {

enum class LogLevel : std::uint8_t { debug, info, warning, error };

// What most likely caused an event, so that an administrator knows where to look first.
enum class Cause : std::uint8_t {
  none,           // no fault, or unknown
  configuration,  // a value in the configuration
  device,         // the sensor or its cable
  bus,            // the bus or network between sensor or client and this machine
  machine,        // this machine: too slow, out of memory or disk
  slipd           // slipd itself
};
// The name as in the journal: "configuration", …; none: empty. Called from any thread.
std::string_view to_string(Cause cause) noexcept;

// What a log line is about.
struct LogContext {
  // The sensor's name; empty: no single sensor.
  std::string_view sensor;
  // What most likely caused it.
  Cause cause = Cause::none;
};

// A formatted line.
struct LogLine {
  LogLevel level = LogLevel::info;
  Cause cause = Cause::none;
  // The sensor's name, ended by 0; cut if longer; empty: no single sensor.
  char sensor[40] = {};
  // The text, ended by 0; cut if longer.
  char text[256] = {};
  // The printf format, a literal. Its address identifies lines of the same kind.
  const char* format = nullptr;
};

// Thread-safe between one writer and io.
class LogRing {
 public:
  // Called from one thread: the ring's writer. `format` is a printf format and a literal. Does not allocate.
  // A line for which the ring has no room is counted as lost.
  __attribute__((format(printf, 4, 5))) void write(LogLevel level, const LogContext& context,
                                                   const char* format, ...) noexcept;

  // Called from one thread: io. Takes the oldest line; false: there is none.
  bool read(LogLine& line) { return lines_.pop(line); }

  // Called from one thread: io. Lines lost since the last call.
  std::uint64_t take_lost() noexcept { return lost_.exchange(0, std::memory_order_relaxed); }

 private:
  // Lines that the ring holds until io prints them, every 20 ms (kLogInterval in service.cpp). Fewer: a burst
  // of errors loses lines. More: more memory, some 300 bytes a line.
  static constexpr std::size_t kLines = 64;
  boost::lockfree::spsc_queue<LogLine, boost::lockfree::capacity<kLines>> lines_;
  std::atomic<std::uint64_t> lost_{0};  // relaxed: an independent counter
};

}  // namespace slipd
