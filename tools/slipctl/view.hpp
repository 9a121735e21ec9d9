// The screen of `slipctl watch`: a pure function from what is known to a grid of characters.
//
// Readable at 80 x 24; every sensor gets an equal share of the rows, and what a share has room for is decided
// from its size alone: name and margin first, then the history, then maps and numbers.
#pragma once

#include <string>

#include "tools/slipctl/canvas.hpp"
#include "tools/slipctl/watch_state.hpp"

namespace slipctl {

Canvas draw_watch(const WatchState& state, int columns, int rows, ColourDepth depth);

// One estimate as a line for logs and pipes.
std::string plain_line(const SensorWatch& sensor, double elapsed_s);

}  // namespace slipctl
