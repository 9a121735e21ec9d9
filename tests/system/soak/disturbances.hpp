// Disturbs a running daemon from outside, in random order: clients that misbehave, recordings whose client
// leaves, SIGSTOP for a while. Runs in a thread of its own.
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <thread>

#include "tests/support/daemon.hpp"

namespace slipd::testing {

class Disturbances {
 public:
  static constexpr std::array kNames{"pauses",           "clients that leave",
                                     "half lines",       "floods of bad JSON",
                                     "endless lines",    "recordings",
                                     "recordings left",  "clients that never read",
                                     "frames asked for", "flights",
                                     "status requests"};

  // Runs until it is destroyed; the daemon must outlive it. Recordings are written to `folder`.
  Disturbances(const Daemon& daemon, const TempFolder& folder, std::uint64_t seed);

  // Stops. Returns how often each disturbance was made.
  std::array<std::uint64_t, kNames.size()> stop();

 private:
  void run(const std::stop_token& stop);
  void act(std::size_t kind);
  void pause();
  void record(bool leave);
  void never_read();
  int up_to(int most) { return 1 + static_cast<int>(random_() % static_cast<unsigned>(most)); }
  std::string sensor();

  const Daemon& daemon_;
  const TempFolder& folder_;
  std::minstd_rand random_;
  std::array<std::uint64_t, kNames.size()> done_{};
  std::jthread thread_;
};

}  // namespace slipd::testing
