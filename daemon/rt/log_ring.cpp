#include "daemon/rt/log_ring.hpp"

#include <algorithm>
#include <cstdarg>
#include <cstdio>

namespace slipd {

std::string_view to_string(Cause cause) noexcept {
  static constexpr std::string_view kNames[] = {"", "configuration", "device", "bus", "machine", "slipd"};
  return kNames[static_cast<std::size_t>(cause)];
}

void LogRing::write(LogLevel level, const LogContext& context, const char* format, ...) noexcept {
  LogLine line;
  line.level = level;
  line.cause = context.cause;
  line.format = format;
  std::copy_n(context.sensor.begin(), std::min(context.sensor.size(), sizeof line.sensor - 1), line.sensor);
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(line.text, sizeof line.text, format, arguments);
  va_end(arguments);
  if (!lines_.push(line)) lost_.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace slipd
