#include "daemon/board/log_ring.hpp"

#include <cstdarg>
#include <cstdio>

namespace slipd {

void LogRing::write(LogLevel level, const char* format, ...) noexcept {
  LogLine line;
  line.level = level;
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(line.text, sizeof line.text, format, arguments);
  va_end(arguments);
  if (!lines_.push(line)) lost_.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace slipd
