// A device misbehaves as ordered, for as many scans as ordered, and in no other way.
#include "tests/devices/misbehaviour.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace slipd::devices {
namespace {

using Kind = Misbehaviour::Kind;
using ::testing::ElementsAre;

const std::vector<Packet> kScan{{1, {10, 11}}, {2, {20, 21}}, {3, {30, 31}}};

std::vector<Packet> distorted(Kind kind) {
  std::vector<Packet> scan = kScan;
  Misbehaviour().distort(kind, scan);
  return scan;
}

TEST(Misbehaviour, ReadsAnOrderAndForHowManyScans) {
  EXPECT_EQ(Misbehaviour::parse("lose 3").kind, Kind::lose);
  EXPECT_EQ(Misbehaviour::parse("lose 3").scans, 3);
  EXPECT_EQ(Misbehaviour::parse(" unplug\n").kind, Kind::unplug);
  EXPECT_EQ(Misbehaviour::parse("garbage").scans, 1);
}

TEST(Misbehaviour, RefusesWhatItDoesNotKnowAndSaysWhatItDoes) {
  for (const char* wrong : {"", "loose 3", "lose -1", "lose 0"}) {
    try {
      Misbehaviour::parse(wrong);
      ADD_FAILURE() << "'" << wrong << "' was taken";
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr("lose, reorder, repeat")) << wrong;
    }
  }
}

TEST(Misbehaviour, LosesThePartInTheMiddle) {
  EXPECT_THAT(distorted(Kind::lose), ElementsAre(kScan[0], kScan[2]));
}

TEST(Misbehaviour, TurnsTheOrderRound) {
  EXPECT_THAT(distorted(Kind::reorder), ElementsAre(kScan[2], kScan[1], kScan[0]));
}

TEST(Misbehaviour, SaysEachPartTwice) {
  EXPECT_THAT(distorted(Kind::repeat),
              ElementsAre(kScan[0], kScan[0], kScan[1], kScan[1], kScan[2], kScan[2]));
}

TEST(Misbehaviour, MakesAPartNoiseOfTheSameLength) {
  const auto scan = distorted(Kind::garbage);
  EXPECT_EQ(scan[1].bytes.size(), kScan[1].bytes.size());
  EXPECT_NE(scan[1].bytes, kScan[1].bytes);
  EXPECT_THAT(scan, ElementsAre(kScan[0], ::testing::_, kScan[2]));
}

TEST(Misbehaviour, GivesAPartTheWrongLength) {
  EXPECT_EQ(distorted(Kind::shorten)[1].bytes, (Bytes{20}));
  EXPECT_EQ(distorted(Kind::lengthen)[1].bytes, (Bytes{20, 21, 0xA5, 0xA5, 0xA5}));
}

}  // namespace
}  // namespace slipd::devices
