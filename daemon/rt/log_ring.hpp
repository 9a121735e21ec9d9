// Log lines from a thread that must not print them: each such thread has a ring of its own, io empties and
// prints it.
#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <string_view>

namespace slipd {

enum class LogLevel : std::uint8_t { debug, info, warning, error };

// Whose doing it is, as far as slipd can tell: where an administrator looks first.
enum class Cause : std::uint8_t { none, configuration, device, bus, machine, slipd };
std::string_view to_string(Cause cause) noexcept;  // "configuration", …; none: empty

struct About {
  std::string_view sensor;  // empty: of none
  Cause cause = Cause::none;
};

struct LogLine {
  LogLevel level = LogLevel::info;
  Cause cause = Cause::none;
  char sensor[40] = {};  // ended by 0, cut if longer, as is the text
  char text[256] = {};
  const char* kind = nullptr;  // its format, a literal: lines that say the same have the same
};

class LogRing {
 public:
  // The ring's own thread. `format` is a literal. Formats as printf into fixed memory; a line for which there
  // is no room is counted instead.
  __attribute__((format(printf, 4, 5))) void write(LogLevel level, const About& about, const char* format,
                                                   ...) noexcept;

  // io. False if there is none.
  bool read(LogLine& line) { return lines_.pop(line); }
  std::uint64_t take_lost() noexcept { return lost_.exchange(0, std::memory_order_relaxed); }

 private:
  boost::lockfree::spsc_queue<LogLine, boost::lockfree::capacity<64>> lines_;
  std::atomic<std::uint64_t> lost_{0};  // relaxed: a number of its own
};

}  // namespace slipd
