// Grippers in their thread: one that loses its order, one that says that it cannot, and ones that hang.
#include "grip/grippers/gripper_thread.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <chrono>
#include <fstream>
#include <functional>

#include "bridges/support/unix_address.hpp"
#include "tests/devices/gripper_on_modbus.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::grip {
namespace {

using devices::GripperOnModbus;
using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

const Command kGrip{.order = {.move = Move::grip, .force_n = 15}, .speed_mm_s = 50, .sequence = 1};

// Orders the same again and again, as slipd-grip does while it holds, until `reached`.
bool holds_until(GripperThread& thread, const std::function<bool()>& reached) {
  constexpr std::chrono::seconds kLongest{60};
  for (const auto until = Clock::now() + kLongest; Clock::now() < until;) {
    if (reached()) return true;
    thread.command(kGrip);
    std::this_thread::yield();
  }
  return false;
}

TEST(GripperThread, TellsOfAGripperThatIsGoneWhileItsOrderStandsAndOrdersItAnewWhenItIsBack) {
  GripperOnModbus device(65);
  GripperThread thread(
      make_modbus_gripper({{"profile", "onrobot-rg2"}, {"at", device.place()}, {"answer_ms", 100}}, 40));
  ASSERT_TRUE(holds_until(thread, [&] { return device.writes() == 1; }));
  device.be_silent(true);
  ASSERT_TRUE(holds_until(thread, [&] { return !thread.condition().answers; }));
  EXPECT_THAT(thread.condition().trouble, HasSubstr("does not answer"));
  device.set_holding(0, 0);  // it forgets its order
  device.be_silent(false);
  ASSERT_TRUE(holds_until(thread, [&] { return device.writes() == 2; }));
  EXPECT_EQ(device.holding(0), 150);
  EXPECT_TRUE(holds_until(thread, [&] { return thread.condition().answers; }));
}

TEST(GripperThread, TellsTheWidthOfNowWhileTheOrderStands) {
  GripperOnModbus device(65);
  device.set_holding(267, 500);
  GripperThread thread(
      make_modbus_gripper({{"profile", "onrobot-rg2"}, {"at", device.place()}, {"answer_ms", 500}}, 40));
  ASSERT_TRUE(holds_until(thread, [&] { return thread.condition().facts.width_mm == 50; }));
  device.set_holding(267, 480);
  EXPECT_TRUE(holds_until(thread, [&] { return thread.condition().facts.width_mm == 48; }));
  EXPECT_EQ(device.writes(), 1) << "looking is no order";
}

TEST(GripperThread, TellsOfAGripperThatWasReset) {
  const testing::TempFolder folder;
  GripperOnModbus device(9, (folder.path() / "tty").string());
  constexpr std::uint16_t kReady = 0x3100;
  device.set_input(2000, kReady);
  GripperThread thread(
      make_modbus_gripper({{"profile", "robotiq-2f85"}, {"at", device.place()}, {"answer_ms", 500}}, 60));
  ASSERT_TRUE(holds_until(thread, [&] { return device.writes() == 1; }));
  device.set_input(2000, 0);
  ASSERT_TRUE(holds_until(thread, [&] { return !thread.condition().answers; }));
  EXPECT_THAT(thread.condition().trouble, HasSubstr("is not activated"));
}

// A program that answers as a shell script says, and counts its starts in a file.
std::unique_ptr<Gripper> program(const testing::TempFolder& folder, const std::string& script) {
  std::ofstream(folder.path() / "gripper.sh") << "echo >> " << (folder.path() / "starts").string() << "\n"
                                              << script;
  return make_line_gripper(
      {{"command", {"/bin/sh", (folder.path() / "gripper.sh").string()}}, {"answer_ms", 20}});
}

int starts_in(const testing::TempFolder& folder) {
  std::ifstream file(folder.path() / "starts");
  return static_cast<int>(
      std::count(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>(), '\n'));
}

TEST(LineGripper, LivesOnWhenItSaysThatItCannot) {
  const testing::TempFolder folder;
  GripperThread thread(program(folder,
                               "read x; echo '{\"fault\": \"too hot\"}'\n"
                               "while read x; do echo '{\"width_mm\": 12}'; done\n"));
  ASSERT_TRUE(holds_until(thread, [&] { return !thread.condition().answers; }));
  EXPECT_THAT(thread.condition().trouble, HasSubstr("too hot"));
  ASSERT_TRUE(holds_until(thread, [&] { return thread.condition().facts.width_mm == 12; }));
  EXPECT_EQ(starts_in(folder), 1);
}

TEST(LineGripper, HasTimeToStart) {
  const testing::TempFolder folder;
  const auto gripper = program(folder, "sleep 0.3; while read x; do echo '{\"width_mm\": 12}'; done\n");
  gripper->connect();
  EXPECT_EQ(gripper->obey(kGrip)->width_mm, 12) << "an interpreter takes longer than an answer does";
  EXPECT_EQ(starts_in(folder), 1);
}

TEST(LineGripper, DoesNotWaitForAProgramThatTakesNoConnection) {
  const testing::TempFolder folder;
  const std::string path = (folder.path() / "gripper.sock").string();
  const devices::Fd listener(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const auto address = bridges::unix_address(path);
  ASSERT_EQ(::bind(listener.get(), reinterpret_cast<const sockaddr*>(&*address), sizeof *address), 0);
  ASSERT_EQ(::listen(listener.get(), 0), 0);
  std::vector<std::unique_ptr<Gripper>> waiting;  // their connections fill its queue
  std::string trouble;
  constexpr int kMany = 16;
  for (int i = 0; i < kMany && trouble.empty(); ++i) {
    waiting.push_back(make_line_gripper({{"socket", path}, {"answer_ms", 20}}));
    try {
      waiting.back()->connect();
    } catch (const GripperError& error) {
      trouble = error.what();
    }
  }
  EXPECT_THAT(trouble, HasSubstr("hangs"));
}

}  // namespace
}  // namespace slipd::grip
