#include "core/model/blocks.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

namespace slipd {
namespace {

// About 5 MB a thread for 10000 taxels: large enough that matrix products run at full speed, small enough for
// a cache.
constexpr std::size_t kBlockColumns = 128;

}  // namespace

void for_each_block(const ColumnSource& source, unsigned threads,
                    const std::function<void(const Block&)>& work,
                    const std::function<void(double)>& progress) {
  const std::size_t rows = source.rows(), columns = source.columns();
  const std::size_t blocks = (columns + kBlockColumns - 1) / kBlockColumns;
  const std::size_t workers =
      std::clamp<std::size_t>(threads, 1, std::min(kLanes, std::max<std::size_t>(blocks, 1)));
  std::atomic<bool> stop{false};
  std::atomic<std::size_t> done{0};
  std::vector<std::exception_ptr> failures(workers);

  const auto run = [&](std::size_t worker) {
    try {
      std::vector<float> memory(rows * std::min(columns, kBlockColumns));
      for (std::size_t lane = worker; lane < kLanes; lane += workers) {
        for (std::size_t b = lane; b < blocks && !stop.load(std::memory_order_relaxed); b += kLanes) {
          const std::size_t first = b * kBlockColumns, count = std::min(kBlockColumns, columns - first);
          source.fill(first, count, memory.data());
          work({lane, first,
                Eigen::Map<const Eigen::MatrixXf>(memory.data(), static_cast<Eigen::Index>(rows),
                                                  static_cast<Eigen::Index>(count))});
          // Relaxed: only a figure for people; the results are handed over by join.
          const std::size_t now = done.fetch_add(count, std::memory_order_relaxed) + count;
          if (worker == 0 && progress) progress(static_cast<double>(now) / static_cast<double>(columns));
        }
      }
    } catch (...) {
      failures[worker] = std::current_exception();
      stop.store(true, std::memory_order_relaxed);
    }
  };

  std::vector<std::thread> others;
  for (std::size_t w = 1; w < workers; ++w) others.emplace_back(run, w);
  run(0);
  for (auto& thread : others) thread.join();
  for (const auto& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
}

}  // namespace slipd
