// Splits the columns of a source among a few threads that live no longer than the call. Training only:
// nothing here runs while frames are estimated.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "paper/dataset/column_source.hpp"

namespace slipd {

// Blocks go to lanes in turn, and each lane adds up for itself: sums then do not depend on how many threads
// there were.
inline constexpr std::size_t kLanes = 4;

// Calls `work(worker, lane, index)` for each index below `count`: those of one lane in order and one at a
// time, different lanes at once on up to `threads` threads (1 … kLanes), which are the workers from 0 on.
// `progress` gets the share that is done. What a worker throws is thrown here, after all have stopped.
void for_each_index(std::size_t count, unsigned threads,
                    const std::function<void(std::size_t worker, std::size_t lane, std::size_t index)>& work,
                    const std::function<void(double)>& progress = {});

// About 5 MB a thread for 10000 taxels: large enough that matrix products run at full speed, small enough for
// a cache.
inline constexpr std::size_t kBlockColumns = 128;

constexpr std::size_t blocks_of(std::size_t columns) noexcept {
  return (columns + kBlockColumns - 1) / kBlockColumns;
}

struct Block {
  std::size_t lane = 0;
  std::size_t first = 0;  // column
  Eigen::Map<const Eigen::MatrixXf> values;
};

// Makes each block of the source and calls `work` with it, as for_each_index does.
void for_each_block(const ColumnSource& source, unsigned threads,
                    const std::function<void(const Block&)>& work,
                    const std::function<void(double)>& progress = {});

}  // namespace slipd
