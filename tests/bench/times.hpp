// What one step took, each time: a mean hides what a controller waits for. Used inside Google Benchmark's
// loop.
#pragma once

#include <benchmark/benchmark.h>
#include <time.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace slipd::bench {

inline std::int64_t now_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{1'000'000'000} * now.tv_sec + now.tv_nsec;
}

struct Quantiles {
  double p50_us = 0, p99_us = 0, p999_us = 0, max_us = 0;
};

// Of times in ns; all zero if there are none.
inline Quantiles quantiles_of(std::vector<std::int64_t> times) {
  if (times.empty()) return {};
  std::sort(times.begin(), times.end());
  const auto at = [&](double share) {
    return 1e-3 * static_cast<double>(
                      times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))]);
  };
  return {at(0.5), at(0.99), at(0.999), at(1)};
}

// Reading the clock twice is part of each time: some 40 ns.
class Times {
 public:
  Times() { times_.reserve(1U << 20U); }
  void add(std::int64_t since_ns) {
    if (times_.size() < times_.capacity()) times_.push_back(now_ns() - since_ns);
  }
  void report(benchmark::State& state) const {
    const Quantiles all = quantiles_of(times_);
    state.counters["p50_us"] = all.p50_us;
    state.counters["p99_us"] = all.p99_us;
    state.counters["p999_us"] = all.p999_us;
    state.counters["max_us"] = all.max_us;
  }

 private:
  std::vector<std::int64_t> times_;
};

}  // namespace slipd::bench
