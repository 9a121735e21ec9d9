// The same work for each of many numbers, on a few threads that live no longer than the call.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

namespace sliplab {

// work(i) for each i below `count`, each once, in no order; done(share) after each, on the calling thread.
// The first exception is thrown here after all have stopped. Results are to be kept by i, so that they do
// not depend on the threads.
template <class Work, class Done>
void for_each_index(std::size_t count, unsigned threads, Work work, Done done) {
  // Each a number of its own; what was worked out is handed over by join.
  std::atomic<std::size_t> next = 0, finished = 0;
  std::vector<std::exception_ptr> failures(std::max(threads, 1U));
  const auto lane = [&](unsigned me) {
    try {
      for (std::size_t i = next++; i < count; i = next++) {
        work(i);
        ++finished;
        if (me == 0) done(static_cast<double>(finished) / static_cast<double>(count));
      }
    } catch (...) {
      failures[me] = std::current_exception();
      next = count;
    }
  };
  std::vector<std::thread> others;
  for (unsigned me = 1; me < failures.size(); ++me) others.emplace_back(lane, me);
  lane(0);
  for (auto& thread : others) thread.join();
  for (const auto& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
}

}  // namespace sliplab
