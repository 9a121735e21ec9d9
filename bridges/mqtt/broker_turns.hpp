// Which broker is tried next, and when. Pure. Any one thread.
#pragma once

#include <chrono>
#include <cstddef>

namespace slipd::mqtt {

struct TurnOptions {
  // Pause after all brokers have failed once. Too small loads a broker that just starts; too large delays
  // messages.
  std::chrono::milliseconds first_pause{500};
  // It doubles with each round up to this.
  std::chrono::milliseconds longest_pause{30'000};
  // A connection that held this long begins the pauses anew. Too small: a broker that accepts and drops
  // clients is asked without end.
  std::chrono::milliseconds steady{10'000};
};

class BrokerTurns {
 public:
  // `brokers`: at least 1. `first`: the one that is tried first, less than `brokers`.
  explicit BrokerTurns(std::size_t brokers, TurnOptions options = {}, std::size_t first = 0);

  // The broker that is tried now, from 0.
  std::size_t current() const noexcept { return current_; }

  // The connection to current() failed or ended; `held`: how long it was accepted. Moves to the next broker.
  // Returns the pause before it is tried. `random`, 0 … 1, shortens the pause to a half at most, so that many
  // grippers that lost one broker do not come back at the same moment.
  std::chrono::milliseconds lost(std::chrono::milliseconds held, double random);

 private:
  TurnOptions options_;
  std::size_t brokers_;
  std::size_t current_;
  std::size_t failed_ = 0;  // in this round
  std::chrono::milliseconds pause_;
};

}  // namespace slipd::mqtt
