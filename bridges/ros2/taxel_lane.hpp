// Publishes the taxels of sensors. It has a thread and a connection of its own: asking slipd for a frame of
// many taxels and reading its text takes milliseconds, by which the margin in the loop's thread must not be
// late.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <slipd.hpp>
#include <string>
#include <thread>
#include <vector>

#include "bridges/ros2/output.hpp"

namespace slipd::ros2 {

struct TaxelSource {
  std::string sensor;
  std::string frame_id;
  std::unique_ptr<Output<PointCloud2>> output;
};

class TaxelLane {
 public:
  // Starts the thread: each source `rate_hz` times a second, above 0. slipd need not run. Throws
  // std::bad_alloc.
  TaxelLane(const std::string& socket, double rate_hz, std::vector<TaxelSource> sources);

 private:
  void run(const std::stop_token& stop);

  client::Connection slipd_;  // the thread's
  double rate_hz_;
  std::vector<TaxelSource> sources_;
  std::mutex mutex_;  // of stopped_ only, which ends a pause early
  std::condition_variable_any stopped_;
  std::jthread thread_;
};

}  // namespace slipd::ros2
