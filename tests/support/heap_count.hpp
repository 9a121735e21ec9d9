// Counts a thread's heap allocations, so that a test can check that a path allocates nothing. A test that
// uses it lists heap_count.cpp among its sources, which replaces operator new in that program.
#pragma once

#include <cstdint>

namespace slipd::test {

// How often the calling thread has allocated since it began.
std::uint64_t allocations() noexcept;

}  // namespace slipd::test
