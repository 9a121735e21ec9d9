// Devices that hang, vanish, end or send frames of a wrong sensor: each affects its own sensor only, and
// every frame is accounted for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/daemon.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;

json trial(const std::string& name, const json& options = json::object(), const json& more = json::object()) {
  json members{{"stale_after_ms", 200}, {"layout", {{"grid", {16, 16}}, {"pitch_mm", 0.9}}}};
  members.merge_patch(more);
  return trial_sensor(name, options, members);
}

json sensors(std::vector<json> list) {
  return json(std::move(list));
}

const json& sensor_of(const json& result, const std::string& name) {
  for (const json& each : result.at("sensors")) {
    if (each.value("name", each.value("sensor", "")) == name) return each;
  }
  throw std::runtime_error("no sensor " + name);
}

auto state_is(const std::string& name, const std::string& state) {
  return [=](const json& result) { return sensor_of(result, name).at("state") == state; };
}

void expect_closed(const json& sensor) {
  EXPECT_EQ(sensor["received"].get<std::uint64_t>(),
            sensor["estimated"].get<std::uint64_t>() + sensor["skipped"].get<std::uint64_t>())
      << sensor;
}

TEST(Devices, ADriverThatHangsMakesOnlyItsOwnSensorStale) {
  const TempFolder folder;
  Daemon daemon(config_with(folder, sensors({trial("well"),
                                             trial("ill", {{"behaviour", "hang_in_read"}, {"after", 20}})})),
                trial_drivers());
  daemon.wait_for("status", [](const json& s) {
    return sensor_of(s, "ill")["received"] == 20 && sensor_of(s, "ill")["state"] == "stale";
  });
  const auto before = sensor_of(daemon.wait_for("status", state_is("well", "ok")), "well")["estimated"];
  daemon.wait_for("status", [&](const json& s) { return sensor_of(s, "well")["estimated"] > before; });
  EXPECT_EQ(sensor_of(daemon.client().result("gamma"), "ill")["gamma"], nullptr);
}

TEST(Devices, ADriverThatHangsIsSaidToHangInWhatItHangs) {
  const TempFolder folder;
  Daemon daemon(config_with(folder, sensors({trial("well"), trial("reads", {{"behaviour", "hang_in_read"}}),
                                             trial("opens", {{"behaviour", "hang_in_open"}})})),
                trial_drivers());
  const json told = daemon.wait_for("status", [](const json& s) {
    return sensor_of(s, "reads")["trouble"].is_string() && sensor_of(s, "opens")["trouble"].is_string();
  });
  EXPECT_THAT(sensor_of(told, "reads")["trouble"].get<std::string>(),
              ::testing::StartsWith("its driver does not return from read"));
  EXPECT_THAT(sensor_of(told, "opens")["trouble"].get<std::string>(),
              ::testing::StartsWith("its driver does not return from open"));
  EXPECT_EQ(sensor_of(told, "well")["trouble"], nullptr);
  daemon.wait_for_log("its driver does not return from read");
  daemon.wait_for_log("its driver does not return from open");
}

TEST(Devices, ADeviceThatIsNotThereIsAFaultWithItsReasonAndTheOthersGoOn) {
  const TempFolder folder;
  Daemon daemon(config_with(folder, sensors({trial("well"), trial("gone", {{"behaviour", "throw_in_open"}}),
                                             trial("stuck", {{"behaviour", "hang_in_open"}})})),
                trial_drivers());
  daemon.wait_for("gamma", state_is("gone", "fault"));
  daemon.wait_for("gamma", state_is("well", "ok"));
  const json status = daemon.client().result("status");
  EXPECT_EQ(sensor_of(status, "gone")["trouble"], "trial device 7 is not there: plug it in");
  EXPECT_EQ(sensor_of(status, "stuck")["state"], "stale");
  const json listed = daemon.client().result("sensors");
  EXPECT_EQ(sensor_of(listed, "gone")["connected"], false);
  EXPECT_EQ(sensor_of(listed, "gone")["method_reason"], nullptr);
  EXPECT_EQ(sensor_of(listed, "well")["method_reason"], "configured");
  EXPECT_EQ(daemon.client().call("frame", {{"sensor", "gone"}})["error"]["code"], -32003);
}

TEST(Devices, OneThatIsOpenAndSendsNothingIsSaidToBeSilentUntilItSends) {
  const TempFolder folder;
  const auto gate = folder.file("gate");
  Daemon daemon(config_with(folder, sensors({trial("left", {{"gate", gate.string()}})})), trial_drivers());
  const auto silent = [](const json& s) { return sensor_of(s, "left")["trouble"].is_string(); };
  const json told = sensor_of(daemon.wait_for("status", silent), "left");
  EXPECT_THAT(told["trouble"].get<std::string>(), ::testing::HasSubstr("sends nothing"));
  EXPECT_EQ(told["connected"], true);
  EXPECT_EQ(told["receiving"], false);
  std::ofstream(gate) << "open";
  daemon.wait_for("status", [](const json& s) {
    return sensor_of(s, "left")["receiving"] == true && sensor_of(s, "left")["trouble"].is_null();
  });
}

TEST(Devices, ADeviceThatVanishesIsReopened) {
  const TempFolder folder;
  Daemon daemon(config_with(folder, sensors({trial("left", {{"behaviour", "vanish"}, {"after", 50}})})),
                trial_drivers());
  const json status =
      daemon.wait_for("status", [](const json& s) { return sensor_of(s, "left")["reconnects"] >= 2; });
  expect_closed(sensor_of(status, "left"));
  EXPECT_EQ(sensor_of(status, "left")["gaps"], 0) << "a device that comes back begins anew";
}

TEST(Devices, EveryFrameAndGapIsAccountedForAtAnyMoment) {
  const TempFolder folder;
  constexpr int kFrames = 20000;
  Daemon daemon(config_with(folder, sensors({trial("left", {{"behaviour", "end"},
                                                            {"after", kFrames},
                                                            {"burst", true},
                                                            {"gap_every", 10},
                                                            {"corrupt_every", 7}})})),
                trial_drivers());
  const json last = daemon.wait_for("status", [](const json& s) {
    expect_closed(sensor_of(s, "left"));
    return sensor_of(s, "left")["state"] == "stale" && sensor_of(s, "left")["received"] == kFrames;
  });
  const json sensor = sensor_of(last, "left");
  EXPECT_EQ(sensor["gaps"], kFrames / 10);
  EXPECT_EQ(sensor["lost"], kFrames / 10);
  EXPECT_GE(sensor["corrupt"], kFrames / 7);
}

TEST(Devices, ADriverThatWaitsForItsConsumerLosesNothing) {
  const TempFolder folder;
  constexpr int kFrames = 3000;
  Daemon daemon(
      config_with(folder,
                  sensors({trial("left", {{"behaviour", "end"}, {"after", kFrames}, {"paced", true}})})),
      trial_drivers());
  // Waits for the end of the device, since the sensor may also become stale earlier, on a busy machine.
  const json last = daemon.wait_for("status", [](const json& s) {
    return sensor_of(s, "left")["connected"] == false && sensor_of(s, "left")["state"] == "stale" &&
           sensor_of(s, "left")["received"] > 0;
  });
  EXPECT_EQ(sensor_of(last, "left")["received"], kFrames);
  EXPECT_EQ(sensor_of(last, "left")["estimated"], kFrames);
  EXPECT_EQ(sensor_of(last, "left")["skipped"], 0);
}

TEST(Devices, TwoSensorsWithOneDeviceShareOneDriver) {
  const TempFolder folder;
  const json same{{"device", {{"serial", "7"}}}};
  Daemon daemon(config_with(folder, sensors({trial("left", json::object(), same),
                                             trial("right", {{"gamma", 0.4}}, same)})),
                trial_drivers());
  daemon.wait_for("gamma", [](const json& r) {
    return sensor_of(r, "left")["state"] == "ok" && sensor_of(r, "right")["state"] == "ok";
  });
}

TEST(Devices, AFrameOfAnUnknownSensorCountsAsCorrupt) {
  const TempFolder folder;
  Daemon daemon(config_with(folder, sensors({trial("left", {{"behaviour", "wrong_sensor"}, {"after", 5}})})),
                trial_drivers());
  daemon.wait_for("status", [](const json& s) { return sensor_of(s, "left")["corrupt"] > 3; });
}

}  // namespace
}  // namespace slipd::testing
