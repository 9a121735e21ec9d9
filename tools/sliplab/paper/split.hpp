// Which columns train and which test (the paper's section III.B: 70 % and 30 %).
#pragma once

#include <cstdint>
#include <vector>

#include "core/model/dataset.hpp"

namespace sliplab {

enum class SplitKind : std::uint8_t {
  random,     // the paper's: loads of one contact end up on both sides
  by_contact  // no contact is on both sides
};

struct Split {
  std::vector<std::size_t> train, test;  // columns, rising
};

Split split_of(SplitKind kind, const slipd::DataSetSize& size, std::uint64_t seed);

}  // namespace sliplab
