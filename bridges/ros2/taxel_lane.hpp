// Publishes the taxels of sensors. It has a thread and a connection of its own: asking slipd for a frame of
// many taxels and reading its text takes milliseconds, by which the margin in the loop's thread must not be
// late. A frame is published once: of a sensor that has no new one, there is nothing.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <slipd.hpp>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "bridges/ros2/output.hpp"

namespace slipd::ros2 {

struct TaxelSource {
  std::string sensor;
  std::string frame_id;
  std::unique_ptr<Output<PointCloud2>> output;
  std::optional<std::uint64_t> sent;  // number of the frame that was published last
};

class TaxelLane {
 public:
  // The stamp of a sample, as Subjects::stamp_of has it. In the lane's thread.
  using StampOf =
      std::function<std::int64_t(std::string_view sensor, std::uint64_t seq, std::int64_t realtime_ns)>;

  // Starts the thread: each source `rate_hz` times a second, above 0. slipd need not run. Throws
  // std::bad_alloc.
  TaxelLane(const std::string& socket, double rate_hz, std::vector<TaxelSource> sources, StampOf stamp_of);

 private:
  void run(const std::stop_token& stop);
  void publish(TaxelSource& source, const char* answer);

  client::Connection slipd_;  // the thread's
  double rate_hz_;
  std::vector<TaxelSource> sources_;
  StampOf stamp_of_;
  PointCloud2 cloud_;
  std::mutex mutex_;  // of stopped_ only, which ends a pause early
  std::condition_variable_any stopped_;
  std::jthread thread_;
};

}  // namespace slipd::ros2
