// What an administrator does to a running service: changes its configuration, to a valid or an invalid one;
// starts it by its socket.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <array>
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

// What is said of the only sensor.
bool is(const json& gamma, const std::string& state, const std::string& alert) {
  const json& sensor = gamma["sensors"][0];
  return sensor["state"] == state && sensor["alert"] == alert;
}

// Of a notification: method, sensor, state, alert.
using Told = std::array<std::string, 4>;

Told next_event(RpcClient& listener) {
  const json told = listener.notification();
  const json& params = told["params"];
  return {told["method"], params["sensor"], params["state"], params["alert"]};
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
  // Until so many configurations have been taken up.
  void await_reloads(std::size_t count) {
    std::size_t from = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const std::string text = "reload: the new configuration is in force";
      ASSERT_TRUE(await_text(daemon_.program(), &Program::errors, text, from));
      from = daemon_.program().errors().find(text, from) + text.size();
    }
  }
  // From ok and none on, `listener` is told when state or alert of left change.
  void listen_to_left(RpcClient& listener) const {
    daemon_.wait_for("gamma", [](const json& r) { return is(r, "ok", "none"); });
    listener.result("subscribe", {{"sensors", {"left"}}, {"events", {"alert", "state"}}});
  }
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

TEST_F(Reload, ARaisedAlertStandsWithoutFrames) {
  const auto gate = folder_.file("gate");
  std::ofstream{gate};
  const json slips = trial_sensor(
      "left", {{"gamma", 0.05}, {"behaviour", "silent"}, {"after", 100}, {"gate", gate.string()}});
  reload(only(slips));
  daemon_.wait_for("gamma", [](const json& r) { return is(r, "stale", "slip"); });
  std::filesystem::remove(gate);  // no frame comes any more
  const json unchanged = only(slips);
  const json cannot_open = only(trial_sensor("left", {{"behaviour", "throw_in_open"}}));
  const json hangs = only(trial_sensor("left", {{"behaviour", "hang_in_open"}}));
  std::size_t reloads = 1;
  for (const json& next : {unchanged, cannot_open, hangs}) {
    reload(next);
    await_reloads(++reloads);
    const json now = daemon_.client().result("gamma")["sensors"][0];
    EXPECT_EQ(now["alert"], "slip") << now;
    EXPECT_EQ(now["alert_cause"], "margin") << now;
    if (next == cannot_open) daemon_.wait_for("gamma", [](const json& r) { return is(r, "fault", "slip"); });
  }
  EXPECT_EQ(daemon_.stop(), 0);
}

TEST_F(Reload, TellsWhoOnlyListensThatADriverHangs) {
  auto listener = daemon_.client();
  listen_to_left(listener);
  reload(only(trial_sensor("left", {{"behaviour", "hang_in_open"}})));
  EXPECT_EQ(next_event(listener), (Told{"alert", "left", "stale", "unknown"}));
  EXPECT_EQ(next_event(listener), (Told{"state", "left", "stale", "unknown"}));
  EXPECT_EQ(daemon_.stop(), 0);
}

TEST_F(Reload, TellsWhoOnlyListensThatADeviceCannotBeOpened) {
  auto listener = daemon_.client();
  listen_to_left(listener);
  reload(only(trial_sensor("left", {{"behaviour", "throw_in_open"}})));
  EXPECT_EQ(next_event(listener), (Told{"alert", "left", "stale", "unknown"}));
  EXPECT_EQ(next_event(listener), (Told{"state", "left", "stale", "unknown"}));
  EXPECT_EQ(next_event(listener), (Told{"state", "left", "fault", "unknown"}));
}

TEST_F(Reload, TellsWhoOnlyListensThatASensorIsGoneAndThatItIsBack) {
  auto listener = daemon_.client();
  listen_to_left(listener);
  reload(only(trial_sensor("right")));
  EXPECT_EQ(next_event(listener), (Told{"alert", "left", "fault", "unknown"}));
  EXPECT_EQ(next_event(listener), (Told{"state", "left", "fault", "unknown"}));
  reload(only(trial_sensor("left")));
  EXPECT_EQ(next_event(listener), (Told{"state", "left", "stale", "unknown"}));
  Told told;
  do told = next_event(listener);
  while (told[0] != "alert" || told[3] != "none");
}

TEST_F(Reload, TellsWhoWaitsForEstimatesThatItsSensorIsGone) {
  auto subscriber = daemon_.client();
  subscriber.result("subscribe", {{"sensors", {"left"}}});
  reload(only(trial_sensor("right")));
  while (next_event(subscriber) != Told{"estimate", "left", "fault", "unknown"}) {
  }
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
