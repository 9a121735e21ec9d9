// Runs of neighbouring taxels, over which vector loops go. Apart from patch, which finds them, so that loops
// of any room can use them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace slipd {

// The taxels with numbers in [first, end).
struct TaxelRun {
  // Number of the first taxel.
  std::uint32_t first = 0;
  // Number behind the last taxel.
  std::uint32_t end = 0;
};

// Most taxels that a loop takes at once. Every channel has memory for at least so many.
inline constexpr std::size_t kMaxLanes = 16;

}  // namespace slipd
