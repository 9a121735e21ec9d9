#include "tools/slipctl/margin_plot.hpp"

#include <algorithm>
#include <cmath>

#include "tools/slipctl/palette.hpp"

namespace slipctl {
namespace {

// Bits of a braille cell from its top down, left and right column of dots.
constexpr char32_t kDots[2][4] = {{0x01, 0x02, 0x04, 0x40}, {0x08, 0x10, 0x20, 0x80}};
constexpr char32_t kBraille = 0x2800;

Columns lowest_by_column(const std::deque<MarginPoint>& history, double now_s, int columns) {
  Columns lowest(static_cast<std::size_t>(columns));
  for (const MarginPoint& point : history) {
    const double place = (point.time_s - (now_s - kHistorySeconds)) / kHistorySeconds * columns;
    if (!point.gamma || place < 0) continue;
    auto& column = lowest[std::min(static_cast<std::size_t>(place), lowest.size() - 1)];
    column = std::min(column.value_or(*point.gamma), *point.gamma);
  }
  return lowest;
}

}  // namespace

void draw_bar(Canvas& canvas, const Box& box, std::optional<double> gamma, std::optional<double> truth) {
  const Style full{margin_colour(gamma), std::nullopt, false};
  const int eighths =
      gamma ? static_cast<int>(std::lround(std::clamp(*gamma, 0.0, 1.0) * 8 * box.columns)) : 0;
  for (int i = 0; i < box.columns; ++i) {
    const int filled = std::clamp(eighths - 8 * i, 0, 8);
    const char32_t partly = U'▐' - static_cast<char32_t>(filled);  // ▏ one eighth … █ all
    if (filled > 0)
      canvas.put(box.column + i, box.row, partly, full);
    else
      canvas.put(box.column + i, box.row, U'·', {kDim, std::nullopt, false});
  }
  if (!truth || box.columns < 1) return;
  const int mark = std::min(box.columns - 1, static_cast<int>(std::clamp(*truth, 0.0, 1.0) * box.columns));
  canvas.put(box.column + mark, box.row, U'┃', {kViolet, std::nullopt, true});
}

void draw_line(Canvas& canvas, const Box& box, const Columns& values,
               const std::function<Rgb(std::optional<double>)>& colour_of) {
  if (box.columns < 1 || box.rows < 1) return;
  const auto height_of = [&](double gamma) {
    return static_cast<int>(std::lround((1 - std::clamp(gamma, 0.0, 1.0)) * (4 * box.rows - 1)));
  };
  for (int i = 0; i < box.columns; ++i) {
    std::vector<char32_t> cells(static_cast<std::size_t>(box.rows), 0);
    std::optional<double> worst;
    for (std::size_t half = 0; half < 2; ++half) {
      const std::size_t column = 2 * static_cast<std::size_t>(i) + half;
      const auto gamma = values[column];
      if (!gamma) continue;
      worst = std::min(worst.value_or(*gamma), *gamma);
      const int here = height_of(*gamma);
      // Begins next to the end of the column before, so that steep changes stay a line.
      const auto before = column > 0 ? values[column - 1] : std::nullopt;
      const int from = before ? height_of(*before) : here;
      const int first = std::min(here, from + 1);
      const int last = std::max(here, from - 1);
      for (int dot = first; dot <= last; ++dot)
        cells[static_cast<std::size_t>(dot / 4)] |= kDots[half][dot % 4];
    }
    for (int row = 0; row < box.rows; ++row)
      if (const char32_t dots = cells[static_cast<std::size_t>(row)])
        canvas.put(box.column + i, box.row + row, kBraille | dots, {colour_of(worst), std::nullopt, false});
  }
}

void draw_history(Canvas& canvas, const Box& box, const std::deque<MarginPoint>& history, double now_s) {
  if (box.columns < 1) return;
  draw_line(canvas, box, lowest_by_column(history, now_s, 2 * box.columns),
            [](std::optional<double> worst) { return margin_colour(worst); });
}

}  // namespace slipctl
