// Results of many grasps or contacts that do not depend on each other.
#pragma once

#include <cstddef>
#include <functional>
#include <type_traits>
#include <vector>

#include "tools/offline/parallel.hpp"

namespace lab {

// Told how much is done, 0 … 1; may be empty.
using Done = std::function<void(double share)>;

// work(i) for each i below `count`, on so many threads; in the order of i, whatever the threads.
template <class Work>
auto collect(std::size_t count, unsigned threads, const Done& done, Work work) {
  std::vector<std::invoke_result_t<Work&, std::size_t>> results(count);
  offline::for_each_index(
      count, threads, [&](std::size_t i) { results[i] = work(i); },
      [&](double share) {
        if (done) done(share);
      });
  return results;
}

}  // namespace lab
