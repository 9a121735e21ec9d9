// Draws taxels of any layout as maps: pressure as colour, shear as arrows.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tools/slipctl/canvas.hpp"
#include "tools/slipctl/margin_plot.hpp"
#include "tools/slipctl/rpc_values.hpp"

namespace slipctl {

// Values of taxels on a grid of pixels. A pixel that covers several taxels has their mean; a taxel that
// covers several pixels fills them.
struct Raster {
  int columns = 0;                            // pixels in a row
  int rows = 0;                               // rows of pixels
  std::vector<std::optional<double>> values;  // row by row from the top (largest y); absent: no taxel
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
  const std::optional<double>& at(int column, int row) const { return values[index(column, row)]; }
};

Raster rasterise(const TaxelFrame& frame, std::span<const double> values, int columns, int rows);

struct MapSize {
  int columns = 0, rows = 0;  // characters
};

// The largest map of at most `rows` rows and `limit` columns that shows the layout undistorted (a character
// is twice as high as wide). Layouts longer than ten to one are shown as ten to one.
MapSize map_size(const TaxelFrame& frame, int rows, int limit);

// Pressure on a scale of 0…peak_pa. Two pixels per character (half blocks) with 256 or more colours, else
// shades.
void draw_pressure(Canvas& canvas, const Box& box, const TaxelFrame& frame, double peak_pa,
                   ColourDepth depth);

// The direction of shear, coloured by the traction ratio |q| / (mu p). Taxels with less than a twentieth of
// peak_pa show none. friction absent: mu = 1.
void draw_shear(Canvas& canvas, const Box& box, const TaxelFrame& frame, double peak_pa,
                std::optional<double> friction, ColourDepth depth);

}  // namespace slipctl
