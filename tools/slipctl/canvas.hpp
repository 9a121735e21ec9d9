// A grid of coloured characters: the content of a screen as a value. Drawing uses no terminal, so that tests
// check every view as text; encoding turns a canvas into a terminal's bytes or a picture.
//
// Not ncurses: ncursesw draws through a global screen that needs a terminal, and its colour pairs stop at 256
// colours unless terminfo has a direct-colour entry, which most machines lack.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace slipctl {

struct Rgb {
  std::uint8_t red = 0;    // sRGB, 0 … 255
  std::uint8_t green = 0;  // sRGB, 0 … 255
  std::uint8_t blue = 0;   // sRGB, 0 … 255
  bool operator==(const Rgb&) const = default;
};

struct Style {
  std::optional<Rgb> foreground;  // absent: the terminal's own
  std::optional<Rgb> background;  // absent: the terminal's own
  bool bold = false;
  bool operator==(const Style&) const = default;
};

struct Cell {
  char32_t glyph = U' ';  // one column wide
  Style style;
  bool operator==(const Cell&) const = default;
};

class Canvas {
 public:
  Canvas(int columns, int rows);
  int columns() const noexcept { return columns_; }
  int rows() const noexcept { return rows_; }
  const Cell& at(int column, int row) const { return cells_[index(column, row)]; }

  // One glyph, one column wide. Outside the canvas: nothing.
  void put(int column, int row, char32_t glyph, const Style& style = {});

  // UTF-8, cut at `limit` columns (-1: the canvas's edge). Glyphs that are not one column wide become '?', so
  // that no name breaks the grid. Returns the column after the last one written.
  int text(int column, int row, std::string_view utf8, const Style& style = {}, int limit = -1);

  std::string row_text(int row) const;  // without colour, trailing blanks cut
  std::string to_text() const;          // all rows, each ended by a newline
  bool operator==(const Canvas&) const = default;

 private:
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }
  int columns_, rows_;
  std::vector<Cell> cells_;
};

enum class ColourDepth : std::uint8_t { none, basic16, indexed256, rgb };

std::string to_utf8(char32_t glyph);

// The bytes of one row for a terminal: colours and glyphs, ended by a reset; no newline.
std::string encode_row(const Canvas& canvas, int row, ColourDepth depth);

// The bytes that change a terminal's content from `before` to `now`. `before` null or of another size: all of
// `now`.
std::string encode_change(const Canvas* before, const Canvas& now, ColourDepth depth);

// The canvas as SVG, for documents.
std::string to_svg(const Canvas& canvas, std::string_view title);

}  // namespace slipctl
