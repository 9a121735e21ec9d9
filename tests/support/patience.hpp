// How long a test waits for an event.
#pragma once

#include <chrono>

namespace slipd::testing {

// Only a program that hangs takes this long, on any machine under any load. No test passes or fails by how
// much of it was used.
inline constexpr std::chrono::minutes kPatience{5};
inline constexpr int kPollPatience = std::chrono::milliseconds(kPatience).count();  // for poll()

}  // namespace slipd::testing
