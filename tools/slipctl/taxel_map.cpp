#include "tools/slipctl/taxel_map.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/slipctl/palette.hpp"

namespace slipctl {
namespace {

// The bounding rectangle of the taxels, mm.
struct Area {
  double left = 0, bottom = 0, width = 1, height = 1, side = 1;
};

// A taxel's side is the distance from the first taxel to its nearest neighbour: exact for a grid, approximate
// for other layouts.
Area area_of(const TaxelFrame& frame) {
  const auto& x = frame.x_mm;
  const auto& y = frame.y_mm;
  if (x.empty()) return {};
  double side = 0;
  for (std::size_t i = 1; i < x.size(); ++i) {
    const double distance = std::max(std::abs(x[i] - x[0]), std::abs(y[i] - y[0]));
    if (distance > 0 && (side == 0 || distance < side)) side = distance;
  }
  if (side == 0) side = 1;
  const auto [left, right] = std::minmax_element(x.begin(), x.end());
  const auto [bottom, top] = std::minmax_element(y.begin(), y.end());
  return {*left - side / 2, *bottom - side / 2, *right - *left + side, *top - *bottom + side, side};
}

struct PixelRange {
  int first, last;
};

// The pixels whose centres a taxel at `place` covers, else the one with the taxel's centre. Lengths in
// pixels.
PixelRange covered(double place, double half_side, int pixels) {
  constexpr double kRounding = 1e-9;  // pixels: rounding errors of a taxel's edge
  int first = static_cast<int>(std::ceil(place - half_side - 0.5 - kRounding));
  int last = static_cast<int>(std::ceil(place + half_side - 0.5 - kRounding)) - 1;
  if (last < first) first = last = static_cast<int>(std::floor(place));
  return {std::clamp(first, 0, pixels - 1), std::clamp(last, 0, pixels - 1)};
}

bool coloured(ColourDepth depth) {
  return depth == ColourDepth::indexed256 || depth == ColourDepth::rgb;
}

void draw_shades(Canvas& canvas, const Box& box, const Raster& pressure, double peak_pa) {
  constexpr char32_t kShades[] = {U'·', U'░', U'▒', U'▓', U'█'};
  for (int row = 0; row < box.rows; ++row)
    for (int column = 0; column < box.columns; ++column)
      if (const auto value = pressure.at(column, row)) {
        const double share = std::clamp(*value / peak_pa, 0.0, 1.0);
        canvas.put(box.column + column, box.row + row, kShades[static_cast<int>(share * 4.999)]);
      }
}

char32_t arrow(double x, double y) {
  constexpr char32_t kArrows[] = {U'→', U'↗', U'↑', U'↖', U'←', U'↙', U'↓', U'↘'};
  const auto eighth = std::lround(std::atan2(y, x) / (std::numbers::pi / 4));
  return kArrows[static_cast<std::size_t>(eighth + 8) % 8];
}

}  // namespace

Raster rasterise(const TaxelFrame& frame, std::span<const double> values, int columns, int rows) {
  Raster raster{columns, rows, {}};
  const std::size_t pixels = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  std::vector<double> sum(pixels, 0);
  std::vector<int> count(pixels, 0);
  const Area area = area_of(frame);
  const double per_mm_x = columns / area.width;
  const double per_mm_y = rows / area.height;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const PixelRange across =
        covered((frame.x_mm[i] - area.left) * per_mm_x, area.side * per_mm_x / 2, columns);
    const double from_top = area.bottom + area.height - frame.y_mm[i];
    const PixelRange down = covered(from_top * per_mm_y, area.side * per_mm_y / 2, rows);
    for (int row = down.first; row <= down.last; ++row)
      for (int column = across.first; column <= across.last; ++column) {
        const std::size_t pixel = raster.index(column, row);
        sum[pixel] += values[i];
        ++count[pixel];
      }
  }
  raster.values.resize(pixels);
  for (std::size_t i = 0; i < pixels; ++i)
    if (count[i] > 0) raster.values[i] = sum[i] / count[i];
  return raster;
}

MapSize map_size(const TaxelFrame& frame, int rows, int limit) {
  const Area area = area_of(frame);
  const double ratio = std::clamp(area.width / area.height, 0.1, 10.0);
  const int columns = 2 * static_cast<int>(std::lround(rows * ratio));
  if (columns <= limit) return {std::max(columns, std::min(2, limit)), rows};
  const int widest = limit > 1 ? limit / 2 * 2 : limit;
  return {widest, std::clamp(static_cast<int>(std::lround(widest / (2 * ratio))), 1, rows)};
}

void draw_pressure(Canvas& canvas, const Box& box, const TaxelFrame& frame, double peak_pa,
                   ColourDepth depth) {
  const double scale = peak_pa > 0 ? peak_pa : 1;
  if (!coloured(depth)) {
    draw_shades(canvas, box, rasterise(frame, frame.normal_pa, box.columns, box.rows), scale);
    return;
  }
  const Raster raster = rasterise(frame, frame.normal_pa, box.columns, 2 * box.rows);
  const auto colour = [&](int column, int row) -> std::optional<Rgb> {
    const auto value = raster.at(column, row);
    return value ? std::optional(pressure_colour(*value / scale)) : std::nullopt;
  };
  for (int row = 0; row < box.rows; ++row)
    for (int column = 0; column < box.columns; ++column) {
      const auto upper = colour(column, 2 * row);
      const auto lower = colour(column, 2 * row + 1);
      if (upper)
        canvas.put(box.column + column, box.row + row, U'▀', {upper, lower, false});
      else if (lower)
        canvas.put(box.column + column, box.row + row, U'▄', {lower, std::nullopt, false});
    }
}

void draw_shear(Canvas& canvas, const Box& box, const TaxelFrame& frame, double peak_pa,
                std::optional<double> friction, ColourDepth depth) {
  // One arrow per square: two columns by one row.
  const int columns = box.columns / 2;
  if (columns < 1 || box.rows < 1) return;
  const Raster pressure = rasterise(frame, frame.normal_pa, columns, box.rows);
  const Raster shear_x = rasterise(frame, frame.shear_x_pa, columns, box.rows);
  const Raster shear_y = rasterise(frame, frame.shear_y_pa, columns, box.rows);
  for (int row = 0; row < box.rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const auto p = pressure.at(column, row);
      if (!p) continue;
      const int left = box.column + 2 * column;
      if (*p <= peak_pa / 20) {
        canvas.put(left, box.row + row, U'·', {kDim, std::nullopt, false});
        continue;
      }
      const double x = *shear_x.at(column, row);
      const double y = *shear_y.at(column, row);
      const double share = std::hypot(x, y) / (friction.value_or(1) * *p);
      Style style;
      if (coloured(depth)) style = {readable_on(traction_colour(share)), traction_colour(share), false};
      canvas.put(left, box.row + row, share < 0.02 ? U'·' : arrow(x, y), style);
      canvas.put(left + 1, box.row + row, U' ', style);
    }
}

}  // namespace slipctl
