// The shipped profiles against simulated grippers of their registers, on a pseudo-terminal and on TCP.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "grip/grippers/gripper_profile.hpp"
#include "tests/devices/gripper_on_modbus.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::grip {
namespace {

using devices::GripperOnModbus;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kMostN = 60;
constexpr std::uint16_t kRobotiqReady = 0x3100;  // gACT, gSTA 3

Command grip_with(double force_n) {
  return {.order = {.move = Move::grip, .force_n = force_n}, .speed_mm_s = 1000, .sequence = 0};
}
Command open_it() {
  return {.order = {.move = Move::open}, .speed_mm_s = 1000, .sequence = 0};
}

std::unique_ptr<Gripper> gripper_at(const std::string& place, const std::string& profile,
                                    double most_n = kMostN) {
  auto gripper = make_modbus_gripper({{"profile", profile}, {"at", place}, {"answer_ms", 500}}, most_n);
  gripper->connect();
  return gripper;
}

std::string trouble_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const GripperError& error) {
    return error.what();
  }
  return {};
}

TEST(Profiles, AreAllOfTheSchema) {
  int found = 0;
  for (const auto& file : std::filesystem::directory_iterator(SLIPD_SOURCE_DIR "/grip/grippers/profiles")) {
    EXPECT_NO_THROW(load_profile(file.path().string())) << file.path();
    ++found;
  }
  EXPECT_GE(found, 4);
}

TEST(Profiles, NeverWriteMoreForceThanTheLimit) {
  for (const char* const name : {"robotiq-2f85", "robotiq-2f140", "onrobot-rg2", "onrobot-rg6"}) {
    const GripperProfile profile = load_profile(name);
    const double most = profile.least_n() + 0.3 * (profile.most_n() - profile.least_n());
    const auto at_limit = profile.write(grip_with(most), most),
               above = profile.write(grip_with(most * 2), most);
    EXPECT_EQ(at_limit.values, above.values) << name;
  }
}

TEST(Robotiq, WritesTheBytesOfTheMakersExamples) {
  const GripperProfile profile = load_profile("robotiq-2f85");
  EXPECT_THAT(profile.write(open_it(), 235).values, ElementsAre(0x0900, 0x0000, 0xFF00))
      << "with the least force";
  EXPECT_THAT(profile.write(grip_with(235), 235).values, ElementsAre(0x0900, 0x00FF, 0xFFFF));
  EXPECT_EQ(profile.write(grip_with(235), 235).first, 0x03E8);
}

TEST(Robotiq, GripsAndTellsItsWidthOverASerialLine) {
  const testing::TempFolder folder;
  GripperOnModbus device(9, (folder.path() / "tty").string());
  device.set_input(2000, kRobotiqReady);
  device.set_input(2002, 230 << 8);
  const auto gripper = gripper_at(device.place(), "robotiq-2f85");
  const auto facts = gripper->obey(grip_with(50));
  ASSERT_TRUE(facts);
  EXPECT_NEAR(*facts->width_mm, 0, 1e-9);
  EXPECT_EQ(device.holding(1001), 0xFF);
  const double force_n = 20 + (device.holding(1002) & 0xFF) * (235.0 - 20) / 255;
  EXPECT_GE(force_n, 50);
  EXPECT_LE(force_n, 51);
}

TEST(Robotiq, IsActivatedOnTheOrderToOpenOnly) {
  const testing::TempFolder folder;
  GripperOnModbus device(9, (folder.path() / "tty").string());
  const auto gripper = gripper_at(device.place(), "robotiq-2f85");
  EXPECT_THAT(trouble_of([&] { gripper->obey(grip_with(30)); }), HasSubstr("is not activated"));
  EXPECT_EQ(device.writes(), 0) << "activation moves the fingers";
  EXPECT_FALSE(gripper->obey(open_it())) << "it is busy with that";
  EXPECT_EQ(device.holding(1000), 0x0100);
  device.set_input(2000, kRobotiqReady);
  EXPECT_TRUE(gripper->obey(open_it()));
  EXPECT_EQ(device.holding(1000), 0x0900);
}

TEST(Robotiq, IsRefusedWhereItsLeastForceIsTooMuch) {
  EXPECT_THAT(trouble_of([&] { gripper_at("/dev/null", "robotiq-2f85", 10); }), HasSubstr("least force"));
}

TEST(OnRobot, GripsOverTcp) {
  GripperOnModbus device(65);
  device.set_holding(267, 423);
  const auto gripper = gripper_at(device.place(), "onrobot-rg2", 30);
  const auto facts = gripper->obey(grip_with(12.34));
  ASSERT_TRUE(facts);
  EXPECT_NEAR(*facts->width_mm, 42.3, 1e-9);
  EXPECT_EQ(device.holding(0), 124) << "0.1 N, rounded up";
  EXPECT_EQ(device.holding(1), 0);
  EXPECT_EQ(device.holding(2), 1);
}

TEST(OnRobot, IsNotOrderedWhileItIsBusy) {
  GripperOnModbus device(65);
  device.set_holding(268, 1);
  const auto gripper = gripper_at(device.place(), "onrobot-rg2", 30);
  EXPECT_FALSE(gripper->obey(grip_with(10)));
  EXPECT_EQ(device.writes(), 0);
  device.set_holding(268, 2);
  EXPECT_TRUE(gripper->obey(grip_with(10)));
}

TEST(OnRobot, TellsOfItsSafetySwitch) {
  GripperOnModbus device(65);
  device.set_holding(268, 1 << 3);
  const auto gripper = gripper_at(device.place(), "onrobot-rg2", 30);
  EXPECT_THAT(trouble_of([&] { gripper->obey(grip_with(10)); }), HasSubstr("fault"));
}

TEST(Gripper, ThatIsSilentIsSaidToBe) {
  GripperOnModbus device(65);
  const auto gripper = gripper_at(device.place(), "onrobot-rg2", 30);
  device.be_silent(true);
  EXPECT_THAT(trouble_of([&] { gripper->obey(grip_with(10)); }), HasSubstr("does not answer"));
  device.be_silent(false);
  gripper->connect();
  EXPECT_TRUE(gripper->obey(grip_with(10)));
}

}  // namespace
}  // namespace slipd::grip
