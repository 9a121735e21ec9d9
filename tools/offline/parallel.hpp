// Runs the same function for many indices on a few threads that end with the call.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

namespace offline {

// Calls work(i) once for each i below `count`, in no particular order, and done(share) on the calling thread.
// Rethrows an exception of work after all threads have stopped. Store results by i, so that they do not
// depend on the threads.
template <class Work, class Done>
void for_each_index(std::size_t count, unsigned threads, Work work, Done done) {
  // Each thread takes its own indices; join() publishes the results.
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

}  // namespace offline
