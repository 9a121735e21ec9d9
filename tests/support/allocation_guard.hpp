// The counts of the allocation guard, in memory shared by the test and the program under test.
#pragma once

#include <atomic>
#include <cstdint>

namespace slipd::testing {

inline constexpr const char* kAllocationGuardFile = "SLIPD_TEST_ALLOCATION_GUARD";

struct AllocationCounts {
  std::atomic<bool> armed{false};
  std::atomic<std::uint64_t> estimate{0}, acquire{0}, can{0};  // by the real-time threads
  std::atomic<std::uint64_t> others{0};  // by all other threads: above 0 shows that the guard counts
};

}  // namespace slipd::testing
