// What an administrator does to a running service: changes its configuration, to a valid or an invalid one;
// starts it by its socket.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>

#include "tests/support/await_output.hpp"
#include "tests/support/daemon.hpp"
#include "tests/support/process_facts.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

bool serves(const json& gamma, const std::string& sensor) {
  return gamma["sensors"].size() == 1 && gamma["sensors"][0]["sensor"] == sensor;
}

class Reload : public ::testing::Test {
 protected:
  // Replaces the configuration file and sends SIGHUP.
  void reload(const json& config) { reload_text(config.dump()); }
  void reload_text(const std::string& text) {
    std::ofstream(daemon_.config()) << text;
    daemon_.program().signal(SIGHUP);
  }
  json only(const json& sensor) const { return config_with(folder_, json::array({sensor})); }
  // Only the log shows a reload that changed nothing.
  void await_error(const std::string& text) const { daemon_.wait_for_log(text); }
  const TempFolder folder_;
  Daemon daemon_{only(trial_sensor("left")), trial_drivers()};
};

TEST_F(Reload, TakesUpAGoodConfigurationAndKeepsItsClients) {
  auto subscriber = daemon_.client();
  subscriber.result("subscribe");
  EXPECT_EQ(subscriber.notification()["params"]["sensor"], "left");
  reload(only(trial_sensor("right")));
  daemon_.wait_for("gamma", [](const json& r) { return serves(r, "right"); });
  json notified;
  do notified = subscriber.notification();
  while (notified["params"]["sensor"] != "right");
  EXPECT_EQ(subscriber.result("version")["name"], "slipd");
}

TEST_F(Reload, ASubscriberByNameGetsItsOwnSensorsOnly) {
  reload(config_with(folder_, json::array({trial_sensor("other"), trial_sensor("left")})));
  daemon_.wait_for("gamma", [](const json& r) { return r["sensors"].size() == 2; });
  auto subscriber = daemon_.client();
  subscriber.result("subscribe", {{"sensors", {"left"}}});
  reload(config_with(folder_, json::array({trial_sensor("left"), trial_sensor("other")})));
  daemon_.wait_for("gamma", [](const json& r) { return r["sensors"][0]["sensor"] == "left"; });
  for (int i = 0; i < 50; ++i) EXPECT_EQ(subscriber.notification()["params"]["sensor"], "left");
}

TEST_F(Reload, KeepsTheOldConfigurationWhenTheNewOneIsBad) {
  reload_text("{ nonsense");
  await_error("the configuration in force stays");
  reload(only({{"name", "left"}, {"driver", "nosuch"}}));
  await_error("/sensors/0/driver");
  reload(only(trial_sensor("left", {{"behaviour", "throw_in_create"}})));
  await_error("the trial device cannot be made");
  EXPECT_TRUE(serves(daemon_.client().result("gamma"), "left"));
  std::filesystem::remove(daemon_.config());
  daemon_.program().signal(SIGHUP);
  await_error("No such file");
  EXPECT_TRUE(serves(daemon_.client().result("gamma"), "left"));
}

TEST_F(Reload, ADriverThatHangsDoesNotKeepItFromTheNextConfiguration) {
  reload(config_with(
      folder_, json::array({trial_sensor("left"), trial_sensor("ill", {{"behaviour", "hang_in_read"}})})));
  daemon_.wait_for("gamma", [](const json& r) { return r["sensors"].size() == 2; });
  reload(only(trial_sensor("right")));
  daemon_.wait_for("gamma",
                   [](const json& r) { return serves(r, "right") && r["sensors"][0]["state"] == "ok"; });
  EXPECT_EQ(daemon_.stop(), 0);
}

TEST_F(Reload, KeepsWhatSensorsHaveLearntBesideADriverThatHangs) {
  const json sensors{trial_sensor("well"),
                     trial_sensor("ill", {{"behaviour", "hang_in_read"}, {"after", 5}})};
  reload(config_with(folder_, sensors));
  daemon_.wait_for("status", [](const json& s) {
    return s["sensors"].size() == 2 && s["sensors"][0]["state"] == "ok" && s["sensors"][1]["received"] == 5 &&
           s["sensors"][1]["state"] == "stale";
  });
  reload(config_with(folder_, sensors, {{"log", {{"level", "debug"}}}}));
  await_error("the driver of ill of the old configuration does not end");
  await_error("well: estimating by moments, with what it had learnt before the reload");
  daemon_.wait_for("gamma", [](const json& r) { return r["sensors"][0]["state"] == "ok"; });
  EXPECT_EQ(daemon_.stop(), 0);
}

TEST_F(Reload, TheFlightRecordersMemoryIsFreedWhileADriverHangs) {
  if (sanitized()) GTEST_SKIP() << "a sanitizer keeps freed memory";
  constexpr std::size_t kHistoryKb = 49'000;  // of 1000 frames of 4096 taxels
  const auto resident = [&] { return resident_kb(daemon_.program().pid()); };
  for (const char* name : {"one", "two", "three", "four"}) {
    const json wide{{"rate_hz", 100}, {"layout", {{"grid", {64, 64}}, {"pitch_mm", 0.3}}}};
    reload(config_with(folder_,
                       json::array({trial_sensor(name, json::object(), wide),
                                    trial_sensor("ill", {{"behaviour", "hang_in_open"}})}),
                       {{"recorder", {{"seconds", 5}}}}));
    daemon_.wait_for("gamma", [&](const json& r) {
      return r["sensors"][0]["sensor"] == name && r["sensors"][0]["state"] == "ok" && resident() > kHistoryKb;
    });
  }
  EXPECT_LT(resident(), 2 * kHistoryKb);
  EXPECT_EQ(daemon_.stop(), 0);
}

TEST_F(Reload, EndsARecordingAndSaysSo) {
  auto client = daemon_.client();
  client.result("record", {{"sensor", "left"}, {"seconds", 1000}});
  UniqueFd reading = client.take_descriptor();
  reload(only(trial_sensor("left")));
  copy_to_end(std::move(reading), folder_.file("r.rec"));
  EXPECT_THAT(client.notification().dump(), HasSubstr("another configuration"));
}

TEST_F(Reload, RepeatedWhileClientsSendRequests) {
  auto asking = daemon_.client();
  auto subscriber = daemon_.client();
  subscriber.result("subscribe");
  for (int i = 0; i < 10; ++i) {
    reload(only(trial_sensor(i % 2 == 0 ? "right" : "left")));
    for (int k = 0; k < 20; ++k) asking.call("frame", {{"sensor", "left"}});
  }
  daemon_.wait_for("gamma", [](const json& r) { return r["sensors"][0]["state"] == "ok"; });
  EXPECT_EQ(daemon_.stop(), 0);
}

TEST(Activation, ServesTheSocketThatItIsPassed) {
  const std::filesystem::path activate = "/usr/bin/systemd-socket-activate";
  if (!std::filesystem::exists(activate)) GTEST_SKIP() << activate << " is not installed";
  const TempFolder folder;
  const auto socket = folder.file("passed.sock");
  const auto config = folder.write("c.json", config_with(folder, json::array({trial_sensor("left")})).dump());
  Program program(folder, "slipd",
                  {activate.string(), "--listen=" + socket.string(), (program_folder() / "slipd").string(),
                   "--config", config.string(), "--driver-dir", trial_drivers().string()},
                  {{"SYSTEMD_LOG_LEVEL", "info"}});
  // Its name is there from bind() on, connections are accepted from listen() on.
  ASSERT_TRUE(await_errors(program, "Listening on " + socket.string()));
  RpcClient client(socket);
  EXPECT_EQ(client.result("version")["name"], "slipd");
  EXPECT_FALSE(std::filesystem::exists(folder.file("s.sock"))) << "socket.path is not served then";
  program.signal(SIGTERM);
  EXPECT_EQ(program.wait(), 0);
  EXPECT_TRUE(std::filesystem::exists(socket)) << "it is not slipd's to remove";
}

}  // namespace
}  // namespace slipd::testing
