#include "daemon/log/log_limit.hpp"

#include <algorithm>
#include <utility>

namespace slipd {

bool LogLimit::admits(const LogLine& line, Clock::time_point now) {
  const auto [place, is_new] = formats_.try_emplace({line.format, static_cast<const char*>(line.sensor)});
  FormatState& kind = place->second;
  if (is_new) kind.until = now + kWindow;
  next_check_ = std::min(next_check_, kind.until);
  Budget& budget = budgets_[line.format];
  if (now >= budget.until) budget = {now + kWindow, 0};
  if (kind.printed < kPrintedPerWindow && budget.printed < kPrintedOfAllSensors) {
    ++kind.printed;
    ++budget.printed;
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
    FormatState& state = kind->second;
    if (state.suppressed.count == 0) {
      kind = formats_.erase(kind);
      continue;
    }
    state.suppressed.within = state.window;
    suppressed.push_back(std::exchange(state.suppressed, {}));
    state.window = std::min(2 * state.window, std::chrono::minutes(kLongestWindow));
    state.until = now + state.window;
    state.printed = kPrintedPerWindow;
    next_check_ = std::min(next_check_, state.until);
    ++kind;
  }
  return suppressed;
}

}  // namespace slipd
