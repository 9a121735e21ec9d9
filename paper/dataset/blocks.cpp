#include "paper/dataset/blocks.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

namespace slipd {

void for_each_index(std::size_t count, unsigned threads,
                    const std::function<void(std::size_t worker, std::size_t lane, std::size_t index)>& work,
                    const std::function<void(double)>& progress) {
  const std::size_t workers =
      std::clamp<std::size_t>(threads, 1, std::min(kLanes, std::max<std::size_t>(count, 1)));
  std::atomic<bool> stop{false};  // relaxed: no other data depends on it; join hands over the failure
  std::atomic<std::size_t> done{0};
  std::vector<std::exception_ptr> failures(workers);

  const auto run = [&](std::size_t worker) {
    try {
      for (std::size_t lane = worker; lane < kLanes; lane += workers) {
        for (std::size_t i = lane; i < count && !stop.load(std::memory_order_relaxed); i += kLanes) {
          work(worker, lane, i);
          // Relaxed: only a figure for people; the results are handed over by join.
          const std::size_t now = done.fetch_add(1, std::memory_order_relaxed) + 1;
          if (worker == 0 && progress) progress(static_cast<double>(now) / static_cast<double>(count));
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

void for_each_block(const ColumnSource& source, unsigned threads,
                    const std::function<void(const Block&)>& work,
                    const std::function<void(double)>& progress) {
  const std::size_t rows = source.rows(), columns = source.columns();
  std::array<std::vector<float>, kLanes> memory;  // of each worker, taken when it needs it
  for_each_index(
      blocks_of(columns), threads,
      [&](std::size_t worker, std::size_t lane, std::size_t index) {
        const std::size_t first = index * kBlockColumns, count = std::min(kBlockColumns, columns - first);
        memory[worker].resize(rows * std::min(columns, kBlockColumns));
        source.fill(first, count, memory[worker].data());
        work({lane, first,
              Eigen::Map<const Eigen::MatrixXf>(memory[worker].data(), static_cast<Eigen::Index>(rows),
                                                static_cast<Eigen::Index>(count))});
      },
      progress);
}

}  // namespace slipd
