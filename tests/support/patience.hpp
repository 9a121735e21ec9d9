// How long a test waits for what must come.
#pragma once

#include <chrono>

namespace slipd::testing {

// Only what will never come takes so long, on any machine and whatever else that does. A test that waits so
// long has found something that hangs; no test passes or fails by how much of it was needed.
inline constexpr std::chrono::minutes kPatience{5};
inline constexpr int kPollPatience = std::chrono::milliseconds(kPatience).count();  // as poll() takes it

}  // namespace slipd::testing
