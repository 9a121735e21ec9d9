#include "daemon/log/log_limit.hpp"

#include <algorithm>

namespace slipd {

bool LogLimit::admits(const LogLine& line, Clock::time_point now) {
  const auto [place, is_new] = formats_.try_emplace({line.format, static_cast<const char*>(line.sensor)});
  FormatState& kind = place->second;
  if (is_new) kind.until = now + kWindow;
  next_check_ = std::min(next_check_, kind.until);
  if (kind.printed < kPrintedPerWindow) {
    ++kind.printed;
    return true;
  }
  kind.suppressed.last = line;
  ++kind.suppressed.count;
  return false;
}

std::vector<LogLimit::Suppressed> LogLimit::take_expired(Clock::time_point now) {
  std::vector<Suppressed> suppressed;
  if (now < next_check_) return suppressed;
  next_check_ = Clock::time_point::max();
  for (auto kind = formats_.begin(); kind != formats_.end();) {
    if (now < kind->second.until) {
      next_check_ = std::min(next_check_, kind->second.until);
      ++kind;
      continue;
    }
    if (kind->second.suppressed.count > 0) suppressed.push_back(kind->second.suppressed);
    kind = formats_.erase(kind);
  }
  return suppressed;
}

}  // namespace slipd
