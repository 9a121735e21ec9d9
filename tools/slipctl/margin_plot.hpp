// Draws the margin as a bar and as a line over the last seconds.
#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "tools/slipctl/canvas.hpp"
#include "tools/slipctl/watch_state.hpp"

namespace slipctl {

struct Box {
  int column = 0;   // left edge
  int row = 0;      // upper edge
  int columns = 0;  // width, characters
  int rows = 0;     // height, characters
};

// A bar of 0…1 in eighths of a column, with a mark at the truth where it is known. gamma absent: an empty
// bar.
void draw_bar(Canvas& canvas, const Box& box, std::optional<double> gamma, std::optional<double> truth);

// Values of 0…1, two to each column of the box; absent: a gap.
using Columns = std::vector<std::optional<double>>;

// A line in braille dots. `colour_of` receives the lower value of each character.
void draw_line(Canvas& canvas, const Box& box, const Columns& values,
               const std::function<Rgb(std::optional<double>)>& colour_of);

// The history in braille dots, newest at the right; `box` spans the last kHistorySeconds up to now_s. Each
// column of dots shows the lowest margin of its interval, so that the shortest slip is visible; an interval
// without a margin is a gap.
void draw_history(Canvas& canvas, const Box& box, const std::deque<MarginPoint>& history, double now_s);

}  // namespace slipctl
