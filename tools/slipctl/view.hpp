// The screen of `slipctl watch`: a pure function from the watch's state to a grid of characters.
//
// Readable at 80 x 24. Every sensor gets an equal share of the rows. The size of a share alone determines its
// content: name and margin first, then the history, then maps and numbers.
#pragma once

#include <string>

#include "tools/slipctl/canvas.hpp"
#include "tools/slipctl/watch_state.hpp"

namespace slipctl {

Canvas draw_watch(const WatchState& state, int columns, int rows, ColourDepth depth);

// One estimate as a line for logs and pipes.
std::string plain_line(const SensorWatch& sensor, double elapsed_s);

}  // namespace slipctl
