// slipd as it runs for a benchmark: the real program, its own folder for state, and what the kernel says of
// it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/daemon.hpp"

namespace slipd::bench {

// A trial device on a square pad: its frames are copied, not computed, and stamped when they are complete.
nlohmann::json trial(const std::string& name, std::size_t side, double rate_hz,
                     const nlohmann::json& options = {});

// config_with, and no limit on clients that matters.
nlohmann::json config(const testing::TempFolder& folder, const nlohmann::json& sensors,
                      const std::string& method, const nlohmann::json& more = nlohmann::json::object());

// ModelProvider are kept in bench::folder() from one run to the next.
testing::Program::Environment state();

void wait_for_estimates(const testing::Daemon& daemon, std::uint64_t count);

struct Usage {
  double cpu_s = 0;                                   // of all threads
  double resident_mb = 0, locked_mb = 0, own_mb = 0;  // own: not shared with files
};
Usage usage_of(pid_t pid);

// CPU time of the process's running threads so far, s, to the nanosecond.
double thread_cpu_s(pid_t pid);

}  // namespace slipd::bench
