// The taxels drawn as maps, whatever their layout: pressure as colour, shear as arrows.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tools/slipctl/canvas.hpp"
#include "tools/slipctl/margin_plot.hpp"
#include "tools/slipctl/rpc_values.hpp"

namespace slipctl {

// Taxels seen through a raster: row by row from the top (y large) down, absent where no taxel lies. A pixel
// that covers several taxels shows their mean, a taxel that covers several pixels fills them.
struct Raster {
  int columns = 0, rows = 0;
  std::vector<std::optional<double>> values;
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
  const std::optional<double>& at(int column, int row) const { return values[index(column, row)]; }
};

Raster rasterise(const TaxelFrame& frame, std::span<const double> values, int columns, int rows);

// How many columns a map of `rows` rows takes to show the layout undistorted (a character is twice as high as
// wide), at most `limit`.
int map_columns(const TaxelFrame& frame, int rows, int limit);

// Pressure on a scale of 0…peak_pa. Two pixels a character (half blocks) where there are colours enough for
// it, shades where not.
void draw_pressure(Canvas& canvas, const Box& box, const TaxelFrame& frame, double peak_pa,
                   ColourDepth depth);

// Where the shear points, coloured by what share of friction it takes: |q| / (mu p). Taxels pressed with less
// than a twentieth of peak_pa show none. friction absent: 1 is taken.
void draw_shear(Canvas& canvas, const Box& box, const TaxelFrame& frame, double peak_pa,
                std::optional<double> friction, ColourDepth depth);

}  // namespace slipctl
