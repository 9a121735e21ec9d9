// slipd's shared memory as a benchmark looks at it: without a system call of slipd's.
#pragma once

#include <slipd.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "clients/c/board_view.hpp"
#include "tests/support/daemon.hpp"

namespace slipd::bench {

// One estimate, times of CLOCK_MONOTONIC.
struct SeenEstimate {
  std::uint64_t number = 0;       // of its sensor
  std::int64_t sample_ns = 0;     // when the device had its frame
  std::int64_t published_ns = 0;  // when it was in the shared memory
};

class BoardWatch {
 public:
  // Has slipd make its shared memory, by libslipd, which attaches to this sensor. Throws std::runtime_error.
  BoardWatch(const testing::Daemon& daemon, const std::string& sensor);

  // The estimates of all sensors that are there at so many even times a second. One that is replaced between
  // two of them is not seen.
  std::vector<SeenEstimate> sample(std::chrono::nanoseconds how_long, std::size_t looks_a_second);

  std::size_t sensors() const { return view_.slots(); }

 private:
  struct Close {
    void operator()(slipd_client* client) const { slipd_close(client); }
  };
  std::unique_ptr<slipd_client, Close> client_;
  client::BoardView view_;
  std::vector<std::uint64_t> seen_;  // number of each sensor's last estimate
};

}  // namespace slipd::bench
