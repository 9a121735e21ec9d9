// Counts what a thread takes from the heap, so that a test can show that a path takes nothing. A test that
// wants it lists heap_count.cpp among its sources, which replaces operator new for that one program.
#pragma once

#include <cstdint>

namespace slipd::test {

// How often the calling thread has allocated since it began.
std::uint64_t allocations() noexcept;

}  // namespace slipd::test
