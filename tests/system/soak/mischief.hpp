// What may befall a running daemon from outside, one thing after another, drawn by chance: clients of every
// bad habit, recordings that are left, a process that stands still for a while. In a thread of its own.
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <thread>

#include "tests/support/daemon.hpp"

namespace slipd::testing {

class Mischief {
 public:
  static constexpr std::array kNames{"standstills",      "clients that leave",
                                     "half lines",       "floods of bad JSON",
                                     "endless lines",    "recordings",
                                     "recordings left",  "clients that never read",
                                     "frames asked for", "flights",
                                     "reports"};

  // Until it is destroyed. The daemon outlives it; `folder` is for recordings.
  Mischief(const Daemon& daemon, const TempFolder& folder, std::uint64_t seed);

  // Stops; how often each was done.
  std::array<std::uint64_t, kNames.size()> stop();

 private:
  void run(const std::stop_token& stop);
  void act(std::size_t kind);
  void stand_still();
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
