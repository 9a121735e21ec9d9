#include "daemon/board/latency.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace slipd {

std::size_t LatencyHistogram::bucket_of(std::uint64_t nanoseconds) noexcept {
  constexpr std::uint64_t kLinear = std::uint64_t{1} << kSubBits;
  if (nanoseconds < kLinear) return nanoseconds;
  const int octave = static_cast<int>(std::bit_width(nanoseconds)) - 1 - kSubBits;
  return (static_cast<std::size_t>(octave + 1) << kSubBits) + ((nanoseconds >> octave) & (kLinear - 1));
}

double LatencyHistogram::upper_edge_us(std::size_t bucket) noexcept {
  constexpr std::size_t kLinear = std::size_t{1} << kSubBits;
  if (bucket < kLinear) return static_cast<double>(bucket + 1) * 1e-3;
  const int octave = static_cast<int>(bucket >> kSubBits) - 1;
  return std::ldexp(static_cast<double>(kLinear + (bucket & (kLinear - 1)) + 1), octave) * 1e-3;
}

void LatencyHistogram::record(std::int64_t nanoseconds) noexcept {
  const auto value = static_cast<std::uint64_t>(std::max<std::int64_t>(0, nanoseconds));
  // There is one writer, so load and store need not be one atomic operation.
  auto& count = counts_[bucket_of(value)];
  count.store(count.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  if (value > max_ns_.load(std::memory_order_relaxed)) max_ns_.store(value, std::memory_order_relaxed);
}

LatencyHistogram::Counts LatencyHistogram::counts() const noexcept {
  Counts counts{};
  for (std::size_t i = 0; i < kBuckets; ++i) counts[i] = counts_[i].load(std::memory_order_relaxed);
  return counts;
}

LatencyHistogram::Summary LatencyHistogram::summary() const noexcept {
  Summary result = summary_of(counts());
  result.max_us = static_cast<double>(max_ns_.load(std::memory_order_relaxed)) * 1e-3;
  for (double* quantile : {&result.p50_us, &result.p99_us, &result.p999_us})
    *quantile = std::min(*quantile, result.max_us);
  return result;
}

LatencyHistogram::Summary LatencyHistogram::summary_of(const Counts& counts) noexcept {
  Summary result;
  for (std::size_t i = 0; i < kBuckets; ++i) {
    result.count += counts[i];
    if (counts[i] > 0) result.max_us = upper_edge_us(i);
  }
  const auto quantile = [&](double share) {
    const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(result.count)));
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      seen += counts[i];
      if (seen >= wanted && seen > 0) return upper_edge_us(i);
    }
    return 0.0;
  };
  result.p50_us = quantile(0.5);
  result.p99_us = quantile(0.99);
  result.p999_us = quantile(0.999);
  return result;
}

}  // namespace slipd
