// The skeleton of a bridge with the real slipd.
#include <gmock/gmock.h>

#include <csignal>
#include <fstream>
#include <iterator>

#include "tests/support/await_output.hpp"
#include "tests/support/daemon.hpp"
#include "tests/support/notify_socket.hpp"

namespace slipd::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const std::string kPrinter = std::string(SLIPD_BINARY_DIR) + "/test-bin/bridge-printer";

TEST(BridgeProgram, EndsWithTwoForWrongUse) {
  EXPECT_EQ(run({kPrinter}).code, 2);
  const TempFolder folder;
  const Ran wrong = run({kPrinter, "--check-config", "--config", folder.write("a.json", "{}")});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.errors, HasSubstr("<3>"));
  EXPECT_THAT(wrong.errors, HasSubstr("a.json"));
  EXPECT_THAT(wrong.errors, HasSubstr("socket"));
  const Ran fine =
      run({kPrinter, "--check-config", "--config", folder.write("b.json", R"({"socket": "/x"})")});
  EXPECT_EQ(fine.code, 0);
  EXPECT_THAT(run({kPrinter, "--version"}).output, HasSubstr("bridge-printer "));
}

TEST(BridgeProgram, FollowsSlipdThroughARestartAndEndsOnRequest) {
  const TempFolder folder;
  const auto config = config_with(folder, {trial_sensor("left"), trial_sensor("right")});
  const auto settings = folder.write("p.json", nlohmann::json{{"socket", config["socket"]["path"]}}.dump());
  Program printer(folder, "printer", {kPrinter, "--config", settings});
  ASSERT_TRUE(await_output(printer, "away"));
  {
    Daemon slipd(config, trial_drivers());
    ASSERT_TRUE(await_output(printer, "serves left right"));
    ASSERT_TRUE(await_output(printer, "estimate left"));
    ASSERT_TRUE(await_output(printer, "estimate right"));
    slipd.stop();
  }
  const std::size_t before = printer.output().size();
  const std::size_t away_at = printer.output().find("serves");
  ASSERT_TRUE(await_output(printer, "away", away_at));
  {
    Daemon slipd(config, trial_drivers());
    ASSERT_TRUE(await_output(printer, "serves left right", before));
    ASSERT_TRUE(await_output(printer, "estimate left", before));
  }
  printer.signal(SIGTERM);
  EXPECT_EQ(printer.wait(), 0);
  EXPECT_THAT(printer.output(), HasSubstr("end"));
  EXPECT_THAT(printer.output(), Not(HasSubstr("wrong")));
}

TEST(BridgeProgram, ReadsItsSettingsAgainOnlyIfTheyAreRight) {
  const TempFolder folder;
  const auto settings = folder.write("p.json", R"({"socket": "/nowhere", "word": "first"})");
  Program printer(folder, "printer", {kPrinter, "--config", settings});
  ASSERT_TRUE(await_output(printer, "word first"));
  folder.write("p.json", R"({"socket": "/nowhere", "word": "second"})");
  printer.signal(SIGHUP);
  ASSERT_TRUE(await_output(printer, "word second"));
  folder.write("p.json", R"({"socket": 3, "word": "third"})");
  printer.signal(SIGHUP);
  ASSERT_TRUE(await_errors(printer, "stay as they were"));
  EXPECT_THAT(printer.errors(), HasSubstr("/socket"));
  printer.signal(SIGTERM);
  EXPECT_EQ(printer.wait(), 0);
  EXPECT_THAT(printer.output(), Not(HasSubstr("third")));
}

// Of all bridges: it is fed by the loop that they have of the skeleton.
TEST(BridgeProgram, FeedsItsWatchdogAlsoWhileSlipdHangs) {
  const TempFolder folder;
  const auto config = config_with(folder, nlohmann::json::array({trial_sensor("left")}));
  const auto settings = folder.write("p.json", nlohmann::json{{"socket", config["socket"]["path"]}}.dump());
  const NotifySocket manager(folder.file("notify"));
  Daemon slipd(config, trial_drivers());
  Program printer(folder, "printer", {kPrinter, "--config", settings},
                  {{"NOTIFY_SOCKET", folder.file("notify").string()}, {"WATCHDOG_USEC", "1000000"}});
  ASSERT_TRUE(await_output(printer, "estimate left"));
  slipd.program().signal(SIGSTOP);
  ASSERT_TRUE(await_output(printer, "away"));
  manager.forget();
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(manager.says("WATCHDOG=1", kPatience));
  slipd.program().signal(SIGCONT);
  printer.signal(SIGTERM);
  EXPECT_EQ(printer.wait(), 0);
}

TEST(BridgeProgram, TheUnitOfEachBridgeAsksForItsWatchdog) {
  for (const char* bridge : {"modbus", "mqtt", "ros2", "web"}) {
    std::ifstream unit(std::string(SLIPD_SOURCE_DIR) + "/bridges/" + bridge + "/slipd-" + bridge +
                       ".service.in");
    const std::string text{std::istreambuf_iterator<char>(unit), {}};
    EXPECT_THAT(text, HasSubstr("\nWatchdogSec=")) << bridge;
  }
}

}  // namespace
}  // namespace slipd::testing
