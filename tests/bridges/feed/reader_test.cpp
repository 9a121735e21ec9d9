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

}  // namespace
}  // namespace slipd::feed
