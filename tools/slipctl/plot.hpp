// `slipctl plot`: a recording on the terminal, without a daemon: its margin, alerts and forces over time, and
// the taxels at one moment. The drawing is a pure function.
#pragma once

#include <optional>
#include <string>

#include "tools/recorded/recorded.hpp"
#include "tools/slipctl/canvas.hpp"

namespace slipctl {

struct PlotOptions {
  std::string file;
  std::optional<double> at_s;  // which moment's taxels are shown; absent: that of least margin
  int columns = 0;             // 0: as the terminal has
  std::string picture;         // the screen as SVG goes into this file; empty: nowhere
  bool json = false;           // a line for each frame instead
};

Canvas draw_recorded(const slipd::Recorded& recorded, const std::string& title, int columns, int rows,
                     ColourDepth depth);

// Throws ClientError for a file that is no recording or cannot be written.
void plot(const PlotOptions& options);

}  // namespace slipctl
