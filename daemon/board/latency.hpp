// How long things took, in fixed memory: logarithmic buckets, eight to each doubling, so a quantile is right
// within 13 %. Written by one real-time thread, read by io at any time.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace slipd {

class LatencyHistogram {
 public:
  struct Summary {
    std::uint64_t count = 0;
    double p50_us = 0, p99_us = 0,
           p999_us = 0;  // upper edges of their buckets, at most max_us; 0 if count is 0
    double max_us = 0;   // exact
  };

  using Counts = std::array<std::uint64_t, std::size_t{64} << 3>;  // of each bucket

  // The writer's thread. Wait-free. Negative times (a recording's clock may run ahead) count as 0.
  void record(std::int64_t nanoseconds) noexcept;

  // Any thread. A summary taken while the writer goes on may miss its last few values.
  Summary summary() const noexcept;
  Counts counts() const noexcept;
  // Of counts alone: max_us is then the upper edge of the last bucket that is not empty.
  static Summary summary_of(const Counts& counts) noexcept;

 private:
  static constexpr int kSubBits = 3;
  static constexpr std::size_t kBuckets = std::tuple_size_v<Counts>;
  static std::size_t bucket_of(std::uint64_t nanoseconds) noexcept;
  static double upper_edge_us(std::size_t bucket) noexcept;
  // Relaxed everywhere: each is a number of its own, nothing else is read on its word.
  std::array<std::atomic<std::uint64_t>, kBuckets> counts_{};
  std::atomic<std::uint64_t> max_ns_{0};
};

}  // namespace slipd
