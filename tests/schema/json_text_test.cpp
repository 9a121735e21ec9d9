// Reading JSON with comments: what is refused, and the position in the error.
#include "schema/json_text.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace slipd {
namespace {

std::string error_of(const std::string& text) {
  try {
    parse_json_text(text);
  } catch (const JsonTextError& e) {
    return e.located_in("f");
  }
  return "";
}

TEST(JsonText, ReadsCommentsAndEveryKindOfValue) {
  const auto v = parse_json_text("// one\n{ \"a\": [1, -2, 3.5, true, null, \"é\"], /* two */ \"b\": {} }");
  EXPECT_EQ(v, nlohmann::json::parse(R"({"a":[1,-2,3.5,true,null,"é"],"b":{}})"));
}

TEST(JsonText, SaysLineAndColumnOfWhatIsWrong) {
  EXPECT_THAT(error_of("{\n  \"a\": 1,\n  ]\n}"), testing::StartsWith("f:3:3: syntax error"));
  EXPECT_THAT(error_of("{ \"é\": x }"), testing::StartsWith("f:1:8: "));  // counted in characters, not bytes
  EXPECT_THAT(error_of(""), testing::StartsWith("f:1:1: "));
  EXPECT_THAT(error_of("{\"a\": 1"), testing::StartsWith("f:1:7: "));
}

TEST(JsonText, RefusesAKeyGivenTwice) {
  EXPECT_EQ(error_of("{ \"a\": 1,\n  \"a\": 2 }"), "f:2:5: key \"a\" is given twice in one object");
  EXPECT_EQ(error_of(R"([{ "a": 1 }, { "a": 2 }])"), "");
}

TEST(JsonText, RefusesNumbersThatAreNone) {
  for (const char* text : {"NaN", "Infinity", "-Infinity", "1e999", "-1e999", "0x10", "+1", ".5", "1."}) {
    EXPECT_THAT(error_of(text), testing::StartsWith("f:1:")) << text;
  }
  EXPECT_LT(error_of(std::string(100000, '9') + "e999").size(), 400U);
}

TEST(JsonText, RefusesNestingBeyondItsLimitAndOnlyBeyond) {
  const auto nested = [](std::size_t n) { return std::string(n, '[') + std::string(n, ']'); };
  EXPECT_EQ(error_of(nested(kJsonDepth)), "");
  EXPECT_THAT(error_of(nested(kJsonDepth + 1)), testing::HasSubstr("nested deeper than 64 levels"));
  EXPECT_THAT(error_of(std::string(1000000, '[')), testing::HasSubstr("nested deeper"));
}

TEST(JsonText, NeverRepeatsWhatATerminalWouldObey) {
  EXPECT_EQ(plain("caf\xc3\xa9 \x1b[2J\x7f\xc2\x9b!\n"), "caf\xc3\xa9 \\u001b[2J\\u007f\\u009b!\\u000a");
  for (const char* text : {"\"\xd0\x7f\"", "{\"\x7f\": 1, \"\x7f\": 2}", "[\x7f]", "\x1b[2J"}) {
    EXPECT_EQ(error_of(text), plain(error_of(text)));
    EXPECT_NE(error_of(text), "");
  }
}

TEST(JsonText, RefusesWhatIsNoText) {
  EXPECT_NE(error_of("\"\xff\""), "");
  EXPECT_NE(error_of(std::string("{\0}", 3)), "");
  EXPECT_NE(error_of("\x1f\x8b\x08"), "");
}

}  // namespace
}  // namespace slipd
