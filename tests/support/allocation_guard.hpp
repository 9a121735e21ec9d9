// What the allocation guard counts, in memory shared by the test and the program under it.
#pragma once

#include <atomic>
#include <cstdint>

namespace slipd::testing {

inline constexpr const char* kAllocationGuardFile = "SLIPD_TEST_ALLOCATION_GUARD";

struct AllocationCounts {
  std::atomic<bool> armed{false};
  std::atomic<std::uint64_t> estimate{0}, acquire{0}, can{0};  // by the real-time threads
  std::atomic<std::uint64_t> others{0};  // by all others: shows that the guard counts at all
};

}  // namespace slipd::testing
