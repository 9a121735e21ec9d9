// How many taxels are few.
#pragma once

#include <cstddef>

namespace slipd {

// Layouts of at most so many taxels are read as a whole, and over time: no single frame determines their
// margin. Checked with `slipd-lab tradeoff`. Too small: 6 x 6 taxels give margins of their own that mean
// little. Too large: 8 x 8 taxels lose theirs.
inline constexpr std::size_t kFewTaxels = 40;

}  // namespace slipd
