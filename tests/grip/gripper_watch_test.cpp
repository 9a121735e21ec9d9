#include "grip/gripper_watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slipd::grip {
namespace {

using ::testing::HasSubstr;

constexpr std::int64_t kMs = 1'000'000;

class GripperWatchTest : public ::testing::Test {
 protected:
  // Ten seconds of a grip of two fingers; the last word.
  std::string hold(double sensors_n, std::optional<double> force_n, std::optional<double> width_mm = {},
                   int ms = 10'000) {
    std::string last;
    for (int i = 0; i < ms; i += 10) {
      now_ns_ += 10 * kMs;
      last = watch_.judge({.width_mm = width_mm, .force_n = force_n}, reading(sensors_n), true, now_ns_);
    }
    return last;
  }
  static Reading reading(double sensors_n) {
    Reading reading;
    reading.contact = true;
    reading.normal_n = 2 * sensors_n;
    return reading;
  }

  GripperWatch watch_{2};
  std::int64_t now_ns_ = 0;
};

TEST_F(GripperWatchTest, IsContentWithForcesThatAgreeAsSensorsDo) {
  EXPECT_EQ(hold(5, 7), "");
  EXPECT_EQ(hold(7, 5), "");
}

TEST_F(GripperWatchTest, TellsOfAForceThatTheSensorsDoNotFeel) {
  EXPECT_THAT(hold(3, 12), HasSubstr("the gripper measures 12.0 N a finger, and the sensors feel 3.0 N"));
  EXPECT_EQ(hold(5, 5), "");
  EXPECT_THAT(hold(12, 3), HasSubstr("measures 3.0 N")) << "and of one that only they feel";
}

TEST_F(GripperWatchTest, GivesForcesASecondToAgree) {
  EXPECT_EQ(hold(3, 12, {}, 900), "");
  EXPECT_EQ(hold(10, 12, {}, 100), "");
  EXPECT_EQ(hold(3, 12, {}, 900), "");
}

TEST_F(GripperWatchTest, SaysNothingOfATouchOrOfAGripperThatMeasuresNoForce) {
  EXPECT_EQ(hold(0.1, 0.8), "");
  EXPECT_EQ(hold(3, std::nullopt), "");
}

TEST_F(GripperWatchTest, TellsOfAnObjectThatGivesWayAndOfFingersThatAreForcedApart) {
  EXPECT_EQ(hold(5, 5, 40), "");
  EXPECT_EQ(hold(5, 5, 39), "") << "pads give, and grippers tell steps";
  EXPECT_THAT(hold(5, 5, 38), HasSubstr("have closed while they hold"));
  EXPECT_EQ(watch_.width_change_mm(), -2);
  EXPECT_EQ(hold(5, 5, 40), "");
  EXPECT_THAT(hold(5, 5, 42), HasSubstr("have opened while they hold"));
}

TEST_F(GripperWatchTest, BeginsAnewWithEachGrip) {
  hold(5, 5, 40);
  EXPECT_EQ(watch_.judge({.width_mm = 80, .force_n = 0}, reading(0), false, now_ns_), "");
  EXPECT_FALSE(watch_.width_change_mm());
  EXPECT_EQ(hold(5, 5, 20), "");
}

}  // namespace
}  // namespace slipd::grip
