// Counts a thread's heap allocations, so that a test can check that a path allocates nothing. A test that
// uses it lists heap_count.cpp among its sources; that file replaces operator new in the program.
#pragma once

#include <cstdint>

namespace slipd::test {

// Allocations of the calling thread since it began.
std::uint64_t allocations() noexcept;

}  // namespace slipd::test
