// Splits the columns of a source among a few threads that live no longer than the call. Training only:
// nothing here runs while frames are estimated.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "core/model/column_source.hpp"

namespace slipd {

// Blocks go to lanes in turn, and each lane adds up for itself: sums then do not depend on how many threads
// there were.
inline constexpr std::size_t kLanes = 4;

struct Block {
  std::size_t lane = 0;
  std::size_t first = 0;  // column
  Eigen::Map<const Eigen::MatrixXf> values;
};

// Calls `work` for each block of the source; blocks of one lane come in order and one at a time, different
// lanes at once on up to `threads` threads (1 … kLanes). `progress` gets the share of columns that is done.
// What a worker throws is thrown here, after all have stopped.
void for_each_block(const ColumnSource& source, unsigned threads,
                    const std::function<void(const Block&)>& work,
                    const std::function<void(double)>& progress = {});

}  // namespace slipd
