// Devices that are unplugged again and again, and driver modules that cannot be used: the sensor reports the
// fault, other sensors are not affected, and no resource leaks.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/devices/contacts.hpp"
#include "tests/support/daemon.hpp"
#include "tests/support/process_facts.hpp"
#include "tests/system/faults/cutting_proxy.hpp"

namespace slipd::testing {
namespace {

namespace fs = std::filesystem;
using devices::DeviceSimulator;
using nlohmann::json;
using ::testing::HasSubstr;
using namespace std::chrono_literals;

// How often a slow device is unplugged: SLIPD_REPLUGS.
int wanted_replugs() {
  const char* text = std::getenv("SLIPD_REPLUGS");
  return text != nullptr ? std::stoi(text) : 8;
}

json trial(const std::string& name, const json& options) {
  return trial_sensor(name, options, {{"layout", {{"grid", {8, 8}}, {"pitch_mm", 1.8}}}});
}

std::uint64_t sum(const json& status, const char* member) {
  std::uint64_t all = 0;
  for (const json& sensor : status["sensors"]) all += sensor[member].get<std::uint64_t>();
  return all;
}

// A leak grows with each batch of unplugs; what is allocated once, however late, does not.
TEST(Unplugged, HundredsOfTimesWithoutALeak) {
  constexpr std::uint64_t kFirst = 40, kBatch = 100, kBatches = 3;
  constexpr std::size_t kLittleKb = 128;  // in a batch
  const TempFolder folder;
  json sensors = json::array({trial("steady", json::object())});
  for (int i = 0; i < 8; ++i)
    sensors.push_back(trial("loose" + std::to_string(i), {{"behaviour", "vanish"}, {"after", 5}}));
  Daemon daemon(config_with(folder, sensors), trial_drivers());
  daemon.wait_for("status", [](const json& s) { return sum(s, "reconnects") >= kFirst; });
  const std::size_t descriptors = daemon.descriptors_at_rest();
  const std::size_t running = threads(daemon.program().pid());
  std::size_t kb = resident_kb(daemon.program().pid());
  bool some_batch_is_little = false;
  json after;
  for (std::uint64_t batch = 1; batch <= kBatches; ++batch) {
    after = daemon.wait_for("status",
                            [&](const json& s) { return sum(s, "reconnects") >= kFirst + batch * kBatch; });
    const std::size_t kb_now = resident_kb(daemon.program().pid());
    some_batch_is_little |= kb_now <= kb + kLittleKb;
    kb = kb_now;
  }
  EXPECT_EQ(after["sensors"][0]["reconnects"], 0);
  EXPECT_EQ(after["sensors"][0]["state"], "ok");
  EXPECT_EQ(daemon.descriptors_at_rest(), descriptors);
  EXPECT_EQ(threads(daemon.program().pid()), running);
  if (!sanitized()) {
    EXPECT_TRUE(some_batch_is_little);
  }
  for (const json& sensor : after["sensors"])
    EXPECT_EQ(sensor["received"],
              sensor["estimated"].get<std::uint64_t>() + sensor["skipped"].get<std::uint64_t>());
  EXPECT_EQ(daemon.stop(), 0);
}

// A gripper on Modbus TCP.
class Modbus : public ::testing::Test {
 protected:
  json config(std::uint16_t port) const {
    const json gripper{{"name", "left"},
                       {"driver", "modbus"},
                       {"profile", "onrobot-rg2-ft"},
                       {"device", {{"host", "127.0.0.1"}, {"port", port}}},
                       {"rate_hz", 50},
                       {"stale_after_ms", 300}};
    return config_with(folder_, json::array({gripper}));
  }
  Program::Environment environment() const { return {{"STATE_DIRECTORY", folder_.path().string()}}; }
  std::uint16_t device_port() { return static_cast<std::uint16_t>(std::stoi(simulator_.port().place())); }
  static json await(const Daemon& daemon, const std::function<bool(const json&)>& enough) {
    return daemon.wait_for("status", [&](const json& s) { return enough(s["sensors"][0]); })["sensors"][0];
  }
  static bool lives(const json& sensor) {
    return sensor["connected"] == true && sensor["state"] != "stale" && sensor["state"] != "fault" &&
           sensor["state"] != "learning";
  }

  TempFolder folder_;
  DeviceSimulator simulator_{devices::onrobot_rg2ft(),
                             devices::scripted(devices::onrobot_rg2ft(), 100, {{"noise", 0}}),
                             devices::make_modbus_tcp_port(devices::onrobot_rg2ft(), 0)};
  std::jthread running_{[this](const std::stop_token& stop) { simulator_.run(stop, 100); }};
};

TEST_F(Modbus, UnpluggedAgainAndAgain) {
  Daemon daemon(config(device_port()), real_drivers(), environment());
  await(daemon, lives);
  const std::size_t descriptors = daemon.descriptors_at_rest();
  for (int i = 1; i <= wanted_replugs(); ++i) {
    simulator_.order("unplug");
    await(daemon, [](const json& s) { return s["connected"] == false && s["state"] == "fault"; });
    simulator_.order("plug");
    await(daemon, [&](const json& s) { return s["reconnects"] == i && lives(s); });
  }
  EXPECT_EQ(daemon.descriptors_at_rest(), descriptors);
  EXPECT_EQ(daemon.stop(), 0);
}

TEST_F(Modbus, KilledInTheMiddleOfAnAnswer) {
  CuttingProxy proxy(device_port());
  Daemon daemon(config(proxy.port()), real_drivers(), environment());
  await(daemon, [&](const json&) { return proxy.cuts() >= 12; });
  proxy.stop_cutting();
  const json sensor = await(daemon, lives);
  EXPECT_GE(sensor["reconnects"], 11);
  EXPECT_EQ(daemon.stop(), 0);
}

class Modules : public ::testing::Test {
 protected:
  // In a folder of its own, beside a valid module.
  void SetUp() override { copy("slipd-driver-trial.so"); }
  fs::path copy(const std::string& name, const std::string& from = "slipd-driver-trial.so") const {
    fs::copy_file(trial_drivers() / from, folder_.file(name));
    return folder_.file(name);
  }
  std::string refusal_of(const std::string& driver) const {
    const auto file = folder_.write(
        "c.json", config_with(folder_, json::array({{{"name", "left"}, {"driver", driver}}})).dump());
    const Ran ran = run({(program_folder() / "slipd").string(), "--config", file.string(), "--driver-dir",
                         folder_.path().string()});
    EXPECT_EQ(ran.code, 2);
    EXPECT_THAT(ran.errors, HasSubstr("/sensors/0/driver"));
    return ran.errors;
  }
  TempFolder folder_;
};

TEST_F(Modules, OfAnotherInterfaceAreRefusedWithBothNumbers) {
  copy("slipd-driver-foreign.so", "foreign/slipd-driver-foreign.so");
  EXPECT_THAT(refusal_of("foreign"),
              ::testing::AllOf(HasSubstr("was built for driver interface"), HasSubstr("build it anew")));
}

TEST_F(Modules, ThatAreInvalidAreRefused) {
  const auto half = copy("slipd-driver-half.so");
  // bytes after the last of these sizes are for debuggers only
  for (const std::uintmax_t size : {20000, 5000, 100}) {
    fs::resize_file(half, size);
    EXPECT_THAT(refusal_of("half"), HasSubstr("is cut short"));
  }
  folder_.write("slipd-driver-empty.so", "");
  EXPECT_THAT(refusal_of("empty"), HasSubstr("is no module"));
  folder_.write("slipd-driver-text.so",
                "not a module, though it is longer than the header of one would be: 64 bytes");
  EXPECT_THAT(refusal_of("text"), HasSubstr("is no module"));
  copy("slipd-driver-other.so");
  EXPECT_THAT(refusal_of("other"), HasSubstr("calls itself \"trial\""));
}

TEST(Drivers, ThatThrowOrHangStopTheirOwnSensorOnly) {
  const TempFolder folder;
  Daemon daemon(
      config_with(folder, json::array({trial("steady", json::object()),
                                       trial("throws", {{"behaviour", "throw_in_open"}}),
                                       trial("odd", {{"behaviour", "throw_oddly_in_open"}}),
                                       trial("reads", {{"behaviour", "hang_in_read"}, {"after", 5}}),
                                       trial("opens", {{"behaviour", "hang_in_open"}})})),
      trial_drivers());
  const json status = daemon.wait_for("status", [](const json& s) {
    const json& all = s["sensors"];
    return all[0]["state"] == "ok" && all[1]["state"] == "fault" && all[2]["state"] == "fault" &&
           all[3]["state"] == "stale" && all[3]["received"] == 5;
  });
  EXPECT_THAT(status["sensors"][1]["trouble"].get<std::string>(), HasSubstr("plug it in"));
  EXPECT_THAT(status["sensors"][2]["trouble"].get<std::string>(), HasSubstr("no std::exception"));
  EXPECT_EQ(status["sensors"][4]["connected"], false);
  const auto estimated = status["sensors"][0]["estimated"].get<std::uint64_t>();
  daemon.wait_for("status", [&](const json& s) { return s["sensors"][0]["estimated"] > estimated + 100; });
}

}  // namespace
}  // namespace slipd::testing
