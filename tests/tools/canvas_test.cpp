#include "tools/slipctl/canvas.hpp"

#include <gmock/gmock.h>

namespace slipctl {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Canvas, CutsTextAtItsEdge) {
  Canvas canvas(8, 1);
  EXPECT_EQ(canvas.text(2, 0, "margin left"), 8);
  EXPECT_EQ(canvas.row_text(0), "  margin");
}

TEST(Canvas, CutsTextAtItsLimit) {
  Canvas canvas(20, 1);
  EXPECT_EQ(canvas.text(0, 0, "margin", {}, 3), 3);
  EXPECT_EQ(canvas.row_text(0), "mar");
}

TEST(Canvas, IgnoresWhatLiesOutside) {
  Canvas canvas(4, 2);
  canvas.put(-1, 0, U'x');
  canvas.put(4, 0, U'x');
  canvas.put(0, 2, U'x');
  canvas.text(0, -1, "x");
  EXPECT_EQ(canvas.to_text(), "\n\n");
}

TEST(Canvas, KeepsTheGridWithAnyName) {
  Canvas canvas(20, 1);
  canvas.text(
      0, 0, "a\x1b[2J\n\xff\xe6\x96\x87\xcc\x81z");  // escape, newline, no UTF-8, a wide one, a combining one
  EXPECT_EQ(canvas.row_text(0), "a?[2J????z");
}

TEST(Canvas, KeepsTheGlyphsThatTheViewsUse) {
  Canvas canvas(20, 1);
  canvas.text(0, 0, "Γ ±·–≤→█▀⣿µ");
  EXPECT_EQ(canvas.row_text(0), "Γ ±·–≤→█▀⣿µ");
}

TEST(Encoding, WithoutColourIsPlainText) {
  Canvas canvas(6, 1);
  canvas.text(0, 0, "slip", {Rgb{255, 0, 0}, Rgb{0, 0, 0}, true});
  EXPECT_EQ(encode_row(canvas, 0, ColourDepth::none), "slip  ");
}

TEST(Encoding, EncodesEachDepthOfColour) {
  Canvas canvas(4, 1);
  canvas.text(0, 0, "slip", {Rgb{250, 10, 0}, std::nullopt, false});
  EXPECT_EQ(encode_row(canvas, 0, ColourDepth::rgb), "\x1b[0;38;2;250;10;0mslip\x1b[0m");
  EXPECT_EQ(encode_row(canvas, 0, ColourDepth::indexed256), "\x1b[0;38;5;196mslip\x1b[0m");
  EXPECT_EQ(encode_row(canvas, 0, ColourDepth::basic16), "\x1b[0;91mslip\x1b[0m");
}

TEST(Encoding, WritesOnlyRowsThatChanged) {
  Canvas before(10, 3);
  before.text(0, 0, "above");
  before.text(0, 1, "old");
  Canvas now = before;
  now.text(0, 1, "new");
  const std::string bytes = encode_change(&before, now, ColourDepth::none);
  EXPECT_THAT(bytes, HasSubstr("\x1b[2;1Hnew"));
  EXPECT_THAT(bytes, Not(HasSubstr("above")));
  EXPECT_EQ(encode_change(&now, now, ColourDepth::rgb), "");
}

TEST(Encoding, WritesEverythingAtFirstAndAfterAResize) {
  Canvas small(10, 2);
  Canvas large(12, 2);
  large.text(0, 0, "above");
  EXPECT_THAT(encode_change(nullptr, large, ColourDepth::none), HasSubstr("above"));
  EXPECT_THAT(encode_change(&small, large, ColourDepth::none), HasSubstr("above"));
}

TEST(Picture, IsWellFormedWhateverTheText) {
  Canvas canvas(12, 1);
  canvas.text(0, 0, "<&> ▀█▎→");
  const std::string svg = to_svg(canvas, "a < b & c");
  EXPECT_THAT(svg, HasSubstr("<title>a &lt; b &amp; c</title>"));
  EXPECT_THAT(svg, HasSubstr(">&lt;</text>"));
  EXPECT_THAT(svg, HasSubstr("</svg>"));
}

}  // namespace
}  // namespace slipctl
