#include "bridges/feed_lane/lane.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "bridges/feed/profile.hpp"
#include "bridges/feed/reader.hpp"

namespace slipd::feed {
namespace {

constexpr std::int64_t kPeriodNs = 10'000'000;

// Messages of one taxel of one byte, behind a sequence of a type, at 100 Hz.
class LaneOfCounts : public testing::Test {
 protected:
  void begin(const std::string& type) {
    const std::string profile = R"({ "description": "a cell", "tested": "synthetic", "source": "this test",
      "from": "udp://127.0.0.1:9", "format": "bytes", "unit": "N", "axes": 1, "taxels": 1,
      "sequence": { "offset": 0, "type": ")" +
                                type + R"(" }, "values": { "offset": 2, "type": "u8" } })";
    Profile parsed = parse_profile(profile, "cell", {});
    const slipd_frames frames = parsed.frames;
    lane_.emplace("cell", frames, std::make_unique<Reader>(std::move(parsed)), "/nowhere/slipd.sock");
  }
  void take(std::uint8_t low, std::uint8_t high) {
    const std::uint8_t message[] = {low, high, 0};
    lane_->take({{}, message}, now_ns_ += kPeriodNs);
  }
  Account account() const { return lane_->account(); }

 private:
  std::optional<Lane> lane_;
  std::int64_t now_ns_ = 0;
};

TEST_F(LaneOfCounts, TakesEveryMessageOfASequenceThatWraps) {
  for (const auto* const type : {"u8", "i8"}) {
    begin(type);
    for (int i = 0; i < 1000; ++i) take(static_cast<std::uint8_t>(i), 0);
    EXPECT_EQ(account().messages, 1000U) << type;
    EXPECT_EQ(account().corrupt, 0U) << type;
    EXPECT_EQ(account().repeated, 0U) << type;
    EXPECT_EQ(account().lost, 0U) << type;
  }
}

TEST_F(LaneOfCounts, CountsWhatIsMissingAcrossAWrap) {
  begin("u16le");
  take(0xfe, 0xff);
  take(0x01, 0x00);  // not 0xffff, 0
  EXPECT_EQ(account().lost, 2U);
}

TEST_F(LaneOfCounts, RefusesWhatWasOvertakenAcrossAWrap) {
  begin("u8");
  for (const std::uint8_t sequence : {254, 0, 255, 1}) take(sequence, 0);
  EXPECT_EQ(account().repeated, 1U);
  EXPECT_EQ(account().lost, 1U);
}

TEST_F(LaneOfCounts, HearsASenderThatBeganAnewAfterASecond) {
  begin("u16le");
  take(200, 0);
  for (int i = 0; i < 150; ++i) take(static_cast<std::uint8_t>(i), 0);
  EXPECT_EQ(account().repeated, 99U);
  EXPECT_EQ(account().lost, 0U);
}

}  // namespace
}  // namespace slipd::feed
