// `slipctl plot`: draws a recording on the terminal, without a daemon: its margin, alerts, sliding and forces
// over time, and the taxels of one frame. The drawing is a pure function.
#pragma once

#include <optional>
#include <string>

#include "tools/recorded/recorded.hpp"
#include "tools/slipctl/canvas.hpp"

namespace slipctl {

struct PlotOptions {
  std::string file;            // the recording
  std::optional<double> at_s;  // time of the frame shown, s from the begin; absent: the frame of least margin
  int columns = 0;             // width; 0: the terminal's
  std::string picture;         // file for the screen as SVG; empty: none
  bool json = false;           // print a line for each frame instead
};

Canvas draw_recorded(const slipd::Recorded& recorded, const std::string& title, int columns, int rows,
                     ColourDepth depth);

// Throws ClientError for a file that is not a recording, and for a picture that cannot be written.
void plot(const PlotOptions& options);

}  // namespace slipctl
