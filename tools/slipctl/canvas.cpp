#include "tools/slipctl/canvas.hpp"

#include <algorithm>

namespace slipctl {
namespace {

struct Decoded {
  char32_t glyph;
  std::size_t bytes;
};

// One code point off the front of `utf8`, which is not empty; a byte that begins none counts as '?'.
Decoded decode(std::string_view utf8) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(utf8[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return {first, 1};
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : first >= 0xC0 ? 2 : 0;
  if (length == 0 || utf8.size() < length) return {U'?', 1};
  char32_t glyph = first & (0x7Fu >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return {U'?', 1};
    glyph = (glyph << 6) | (byte(i) & 0x3Fu);
  }
  return {glyph, length};
}

// Latin, Greek, Cyrillic, and the punctuation, arrows, blocks and braille that the views use.
bool one_column(char32_t glyph) {
  if (glyph < 0x20 || (glyph >= 0x7F && glyph < 0xA0) || glyph == 0xAD) return false;
  if (glyph >= 0x300 && glyph < 0x370) return false;  // combining
  return glyph < 0x530 || (glyph >= 0x2010 && glyph < 0x2028) || (glyph >= 0x2190 && glyph < 0x2900);
}

}  // namespace

Canvas::Canvas(int columns, int rows)
    : columns_(std::max(1, columns)),
      rows_(std::max(1, rows)),
      cells_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}

void Canvas::put(int column, int row, char32_t glyph, const Style& style) {
  if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return;
  cells_[index(column, row)] = {glyph, style};
}

int Canvas::text(int column, int row, std::string_view utf8, const Style& style, int limit) {
  const int end = limit < 0 ? columns_ : std::min(columns_, column + limit);
  while (!utf8.empty() && column < end) {
    const auto [glyph, bytes] = decode(utf8);
    utf8.remove_prefix(bytes);
    put(column++, row, one_column(glyph) ? glyph : U'?', style);
  }
  return column;
}

std::string Canvas::row_text(int row) const {
  int end = columns_;
  while (end > 0 && at(end - 1, row).glyph == U' ') --end;
  std::string line;
  for (int column = 0; column < end; ++column) line += to_utf8(at(column, row).glyph);
  return line;
}

std::string Canvas::to_text() const {
  std::string all;
  for (int row = 0; row < rows_; ++row) all += row_text(row) + "\n";
  return all;
}

std::string to_utf8(char32_t glyph) {
  const auto tail = [glyph](int shift) { return static_cast<char>(0x80 | ((glyph >> shift) & 0x3F)); };
  if (glyph < 0x80) return {static_cast<char>(glyph)};
  if (glyph < 0x800) return {static_cast<char>(0xC0 | (glyph >> 6)), tail(0)};
  if (glyph < 0x10000) return {static_cast<char>(0xE0 | (glyph >> 12)), tail(6), tail(0)};
  return {static_cast<char>(0xF0 | (glyph >> 18)), tail(12), tail(6), tail(0)};
}

}  // namespace slipctl
