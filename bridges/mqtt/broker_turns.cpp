#include "bridges/mqtt/broker_turns.hpp"

#include <algorithm>

namespace slipd::mqtt {

BrokerTurns::BrokerTurns(std::size_t brokers, TurnOptions options, std::size_t first)
    : options_(options), brokers_(brokers), current_(first), pause_(options.first_pause) {}

std::chrono::milliseconds BrokerTurns::lost(std::chrono::milliseconds held, double random) {
  current_ = (current_ + 1) % brokers_;
  if (held >= options_.steady) {
    pause_ = options_.first_pause;
    failed_ = 0;
  }
  if (++failed_ < brokers_) return std::chrono::milliseconds(0);
  failed_ = 0;
  const double share = 1 - std::clamp(random, 0.0, 1.0) / 2;
  const auto pause =
      std::chrono::milliseconds(static_cast<std::int64_t>(share * static_cast<double>(pause_.count())));
  pause_ = std::min(2 * pause_, options_.longest_pause);
  return pause;
}

}  // namespace slipd::mqtt
