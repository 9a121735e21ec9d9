// Splits columns into training and test sets (the paper's section III.B: 70 % and 30 %).
#pragma once

#include <cstdint>
#include <vector>

#include "paper/dataset/dataset.hpp"

namespace lab {

enum class SplitKind : std::uint8_t {
  random,     // the paper's: columns of one contact are in both sets
  by_contact  // all columns of one contact are in one set
};

struct Split {
  std::vector<std::size_t> train;  // indices of columns, rising
  std::vector<std::size_t> test;   // indices of columns, rising
};

Split split_of(SplitKind kind, const slipd::DataSetSize& size, std::uint64_t seed);

}  // namespace lab
