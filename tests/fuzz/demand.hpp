// What a fuzz target holds its subject to, in every kind of build.
#pragma once

#include <cstdlib>

namespace slipd::fuzz {

inline void demand(bool holds) {
  if (!holds) std::abort();
}

}  // namespace slipd::fuzz
