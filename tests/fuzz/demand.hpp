// The assertion of fuzz targets, active in every kind of build.
#pragma once

#include <cstdlib>

namespace slipd::fuzz {

inline void demand(bool holds) {
  if (!holds) std::abort();
}

}  // namespace slipd::fuzz
