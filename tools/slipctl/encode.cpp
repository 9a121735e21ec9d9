// A canvas as a terminal's bytes (ECMA-48) and as SVG.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <string>

#include "tools/slipctl/canvas.hpp"

namespace slipctl {
namespace {

int squared_distance(Rgb a, Rgb b) {
  const int red = a.red - b.red;
  const int green = a.green - b.green;
  const int blue = a.blue - b.blue;
  return red * red + green * green + blue * blue;
}

// xterm's default colours 0–15.
constexpr std::array<Rgb, 16> kBasic{{{0, 0, 0},
                                      {205, 0, 0},
                                      {0, 205, 0},
                                      {205, 205, 0},
                                      {0, 0, 238},
                                      {205, 0, 205},
                                      {0, 205, 205},
                                      {229, 229, 229},
                                      {127, 127, 127},
                                      {255, 0, 0},
                                      {0, 255, 0},
                                      {255, 255, 0},
                                      {92, 92, 255},
                                      {255, 0, 255},
                                      {0, 255, 255},
                                      {255, 255, 255}}};

int nearest_basic(Rgb colour) {
  const auto nearer = [colour](Rgb a, Rgb b) {
    return squared_distance(a, colour) < squared_distance(b, colour);
  };
  return static_cast<int>(std::min_element(kBasic.begin(), kBasic.end(), nearer) - kBasic.begin());
}

// The 6 x 6 x 6 cube at 16 and the 24 greys at 232, whichever is nearer.
int nearest_indexed(Rgb colour) {
  constexpr std::array<int, 6> kLevels{0, 95, 135, 175, 215, 255};
  const auto level = [&](int value) {
    const auto nearer = [value](int a, int b) { return std::abs(a - value) < std::abs(b - value); };
    return static_cast<int>(std::min_element(kLevels.begin(), kLevels.end(), nearer) - kLevels.begin());
  };
  const auto channel = [](int value) { return static_cast<std::uint8_t>(value); };
  const int red = level(colour.red);
  const int green = level(colour.green);
  const int blue = level(colour.blue);
  const auto of = [&](int index) { return channel(kLevels[static_cast<std::size_t>(index)]); };
  const Rgb cube{of(red), of(green), of(blue)};
  const int shade = std::clamp((colour.red + colour.green + colour.blue) / 3 - 3, 0, 230) / 10;
  const Rgb grey{channel(8 + 10 * shade), channel(8 + 10 * shade), channel(8 + 10 * shade)};
  if (squared_distance(grey, colour) < squared_distance(cube, colour)) return 232 + shade;
  return 16 + 36 * red + 6 * green + blue;
}

std::string colour_code(Rgb colour, bool background, ColourDepth depth) {
  switch (depth) {
    case ColourDepth::none:
      return "";
    case ColourDepth::basic16: {
      const int basic = nearest_basic(colour);
      return ";" + std::to_string((basic < 8 ? 30 : 82) + basic + (background ? 10 : 0));
    }
    case ColourDepth::indexed256:
      return (background ? ";48;5;" : ";38;5;") + std::to_string(nearest_indexed(colour));
    case ColourDepth::rgb:
      return (background ? ";48;2;" : ";38;2;") + std::to_string(colour.red) + ";" +
             std::to_string(colour.green) + ";" + std::to_string(colour.blue);
  }
  return "";
}

std::string style_code(const Style& style, ColourDepth depth) {
  std::string code = "\x1b[0";
  if (style.bold) code += ";1";
  if (style.foreground) code += colour_code(*style.foreground, false, depth);
  if (style.background) code += colour_code(*style.background, true, depth);
  return code + "m";
}

bool same_row(const Canvas& a, const Canvas& b, int row) {
  for (int column = 0; column < b.columns(); ++column)
    if (a.at(column, row) != b.at(column, row)) return false;
  return true;
}

std::string hex(Rgb colour) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text = "#";
  for (const unsigned channel : {colour.red, colour.green, colour.blue}) {
    text += kDigits[channel >> 4];
    text += kDigits[channel & 15u];
  }
  return text;
}

std::string escaped(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&')
      safe += "&amp;";
    else if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else
      safe += c;
  }
  return safe;
}

constexpr int kCellWidth = 8;
constexpr int kCellHeight = 16;
constexpr Rgb kForeground{220, 220, 220};
constexpr Rgb kBackground{16, 18, 24};

std::string rectangle(int x, int y, int width, int height, Rgb colour) {
  return "<rect x=\"" + std::to_string(x) + "\" y=\"" + std::to_string(y) + "\" width=\"" +
         std::to_string(width) + "\" height=\"" + std::to_string(height) + "\" fill=\"" + hex(colour) +
         "\"/>\n";
}

// Blocks are drawn as rectangles, because a font's block glyphs leave seams; all else is text.
std::string picture_of(const Cell& cell, int column, int row) {
  const int x = column * kCellWidth;
  const int y = row * kCellHeight;
  const Rgb foreground = cell.style.foreground.value_or(kForeground);
  std::string svg;
  if (cell.style.background) svg += rectangle(x, y, kCellWidth, kCellHeight, *cell.style.background);
  if (cell.glyph == U' ') return svg;
  if (cell.glyph == U'▀') return svg + rectangle(x, y, kCellWidth, kCellHeight / 2, foreground);
  if (cell.glyph >= U'█' && cell.glyph <= U'▏')
    return svg + rectangle(x, y + 3, kCellWidth * static_cast<int>(U'▐' - cell.glyph) / 8, kCellHeight - 6,
                           foreground);
  return svg + "<text x=\"" + std::to_string(x) + "\" y=\"" + std::to_string(y + 12) + "\" fill=\"" +
         hex(foreground) + "\"" + (cell.style.bold ? " font-weight=\"bold\"" : "") + ">" +
         escaped(to_utf8(cell.glyph)) + "</text>\n";
}

}  // namespace

std::string encode_row(const Canvas& canvas, int row, ColourDepth depth) {
  std::string line;
  Style current;
  for (int column = 0; column < canvas.columns(); ++column) {
    const Cell& cell = canvas.at(column, row);
    if (depth != ColourDepth::none && cell.style != current) {
      line += style_code(cell.style, depth);
      current = cell.style;
    }
    line += to_utf8(cell.glyph);
  }
  if (current != Style{}) line += "\x1b[0m";
  return line;
}

std::string encode_change(const Canvas* before, const Canvas& now, ColourDepth depth) {
  const bool all = before == nullptr || before->columns() != now.columns() || before->rows() != now.rows();
  std::string bytes = all ? "\x1b[0m\x1b[2J" : "";
  for (int row = 0; row < now.rows(); ++row) {
    if (!all && same_row(*before, now, row)) continue;
    bytes += "\x1b[" + std::to_string(row + 1) + ";1H" + encode_row(now, row, depth);
  }
  return bytes;
}

std::string to_svg(const Canvas& canvas, std::string_view title) {
  const int width = canvas.columns() * kCellWidth;
  const int height = canvas.rows() * kCellHeight;
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + std::to_string(width) + " " +
                    std::to_string(height) + "\" font-family=\"monospace\" font-size=\"13\">\n<title>" +
                    escaped(title) + "</title>\n" + rectangle(0, 0, width, height, kBackground);
  for (int row = 0; row < canvas.rows(); ++row)
    for (int column = 0; column < canvas.columns(); ++column)
      svg += picture_of(canvas.at(column, row), column, row);
  return svg + "</svg>\n";
}

}  // namespace slipctl
