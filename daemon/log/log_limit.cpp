#include "daemon/log/log_limit.hpp"

#include <algorithm>

namespace slipd {

bool LogLimit::admits(const LogLine& line, Clock::time_point now) {
  const auto [place, is_new] = kinds_.try_emplace({line.kind, static_cast<const char*>(line.sensor)});
  Kind& kind = place->second;
  if (is_new) kind.until = now + kInterval;
  look_at_ = std::min(look_at_, kind.until);
  if (kind.printed < kPrinted) {
    ++kind.printed;
    return true;
  }
  kind.held.last = line;
  ++kind.held.count;
  return false;
}

std::vector<LogLimit::Held> LogLimit::over(Clock::time_point now) {
  std::vector<Held> held;
  if (now < look_at_) return held;
  look_at_ = Clock::time_point::max();
  for (auto kind = kinds_.begin(); kind != kinds_.end();) {
    if (now < kind->second.until) {
      look_at_ = std::min(look_at_, kind->second.until);
      ++kind;
      continue;
    }
    if (kind->second.held.count > 0) held.push_back(kind->second.held);
    kind = kinds_.erase(kind);
  }
  return held;
}

}  // namespace slipd
