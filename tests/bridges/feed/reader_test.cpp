#include "bridges/feed/reader.hpp"

#include <gtest/gtest.h>

#include <string>

#include "bridges/feed/profile.hpp"

namespace slipd::feed {
namespace {

std::string profile_of(const std::string& rest) {
  return R"({ "description": "a cell", "tested": "synthetic", "source": "this test",
    "from": "udp://127.0.0.1:9", "unit": "N", "axes": 1, )" +
         rest + "}";
}

TEST(Reader, SaysAfterWhatTimeAClockOfBytesWraps) {
  Reader reader(parse_profile(profile_of(R"("format": "bytes", "taxels": 1, "time_unit_s": 1e-6,
    "time": { "offset": 0, "type": "u32le" }, "values": { "offset": 4, "type": "u8" })"),
                              "cell", {}));
  const std::uint8_t message[] = {1, 0, 0, 0, 9};
  Reading reading;
  ASSERT_EQ(reader.read({{}, message}, reading), Outcome::frame);
  EXPECT_DOUBLE_EQ(reading.sent_s.value(), 1e-6);
  EXPECT_DOUBLE_EQ(reading.sent_range_s, 4294.967296);
}

TEST(Reader, KnowsNoWrapOfNumbersInATextOrOfReals) {
  const std::string text = R"({ "count": 255, "at": 2, "values": [1] })";
  const std::string json = R"("format": "json", "taxels": 1, "sequence": { "at": "/count" },
    "time": { "at": "/at" }, "values": { "at": "/values" })";
  const std::string bytes = R"("format": "bytes", "taxels": 1, "sequence": { "offset": 0, "type": "f32le" },
    "time": { "offset": 0, "type": "f32le" }, "values": { "offset": 4, "type": "u8" })";
  for (const auto& [profile, message] : {std::pair(json, text), std::pair(bytes, std::string(5, '\0'))}) {
    Reader reader(parse_profile(profile_of(profile), "cell", {}));
    Reading reading;
    const std::vector<std::uint8_t> body(message.begin(), message.end());
    ASSERT_EQ(reader.read({{}, body}, reading), Outcome::frame) << reader.why();
    EXPECT_EQ(reading.sequence_bytes, 8U);
    EXPECT_EQ(reading.sent_range_s, 0);
  }
}

// What becomes of a JSON text whose "values" are these, of a sensor of two taxels.
class JsonValues : public testing::Test {
 protected:
  Outcome read(const std::string& values) {
    return read_text(R"({ "device": "a", "values": )" + values + " }");
  }
  Outcome read_text(const std::string& text) {
    const std::vector<std::uint8_t> body(text.begin(), text.end());
    return reader_.read({{}, body}, reading_);
  }
  const std::string& why() const { return reader_.why(); }

 private:
  Reader reader_{parse_profile(profile_of(R"("format": "json", "taxels": 2, "device": "/device",
    "usual_device": "a", "values": { "at": "/values" })"),
                               "cell", {})};
  Reading reading_;
};

std::string nested(std::size_t levels, const std::string& inner) {
  return std::string(levels, '[') + inner + std::string(levels, ']');
}

TEST_F(JsonValues, AreATextAListOrAListOfLists) {
  for (const auto* const values : {R"("1,2")", "[1, 2]", "[[1], [2]]", "[[1, 2]]"})
    EXPECT_EQ(read(values), Outcome::frame) << values;
  EXPECT_EQ(read("[[[1, 2]]]"), Outcome::corrupt);
  EXPECT_EQ(why(), "/values has not the 2 numbers of 2 taxels in a text, a list or a list of lists");
}

TEST_F(JsonValues, NestedAMillionDeepAreRefused) {
  constexpr std::size_t kLevels = 1'900'000;  // 3.8 MB
  EXPECT_EQ(read(nested(kLevels, "1")), Outcome::corrupt);
  EXPECT_EQ(why(), "the message is no JSON text, or is nested more than 16 deep");
  EXPECT_EQ(read_text(R"({ "device": )" + nested(kLevels, "1") + "}"), Outcome::corrupt);
  EXPECT_EQ(read_text(std::string(kLevels, '[')), Outcome::corrupt) << "cut off";
}

TEST_F(JsonValues, MayStandBesideWhatIsNestedLess) {
  const auto beside = [&](const std::string& what) {
    return read_text(R"({ "device": "a", "values": [1, 2], "more": )" + what + "}");
  };
  EXPECT_EQ(beside(nested(15, "1")), Outcome::frame);
  EXPECT_EQ(beside(nested(16, "1")), Outcome::corrupt);
  EXPECT_EQ(beside(R"("\"[[[[[[[[[[[[[[[[[[[[\\")"), Outcome::frame) << "a text is no list";
}

}  // namespace
}  // namespace slipd::feed
