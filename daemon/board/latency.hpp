// A histogram of latencies in fixed memory. Buckets are logarithmic, eight to an octave, so that a quantile
// is exact within 13 %.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace slipd {

// Thread-safe between one writer and any number of readers.
class LatencyHistogram {
 public:
  // Quantiles. All are 0 if count is 0.
  struct Summary {
    // Values recorded.
    std::uint64_t count = 0;
    // Median, us; upper edge of its bucket, at most max_us.
    double p50_us = 0;
    // 99 %, us; the same.
    double p99_us = 0;
    // 99.9 %, us; the same.
    double p999_us = 0;
    // Largest value, us; exact.
    double max_us = 0;
  };

  // Number of values in each bucket.
  using Counts = std::array<std::uint64_t, std::size_t{64} << 3>;

  // Called from one thread: the writer. Wait-free. A negative time counts as 0: the clock of a recording may
  // be ahead.
  void record(std::int64_t nanoseconds) noexcept;

  // Called from any thread. May miss the last values if the writer runs.
  Summary summary() const noexcept;
  // Called from any thread. May miss the last values if the writer runs.
  Counts counts() const noexcept;
  // The summary of counts alone. max_us is then the upper edge of the last bucket that is not empty.
  static Summary summary_of(const Counts& counts) noexcept;

 private:
  // Bits within an octave: 8 buckets for each factor of 2, so that a bucket's width is at most 13 %.
  static constexpr int kSubBits = 3;
  static constexpr std::size_t kBuckets = std::tuple_size_v<Counts>;
  static std::size_t bucket_of(std::uint64_t nanoseconds) noexcept;
  static double upper_edge_us(std::size_t bucket) noexcept;
  // Relaxed everywhere: independent counters; no other memory is read because of them.
  std::array<std::atomic<std::uint64_t>, kBuckets> counts_{};
  std::atomic<std::uint64_t> max_ns_{0};
};

}  // namespace slipd
