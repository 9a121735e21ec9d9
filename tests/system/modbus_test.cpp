// The daemon with its Modbus driver and a simulated gripper on loopback or on a serial line: the margin on
// the socket against the contact's truth, stalls and unplugging. Without a Modbus sensor the process does
// not load libmodbus.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <thread>

#include "tests/devices/contacts.hpp"
#include "tests/support/daemon.hpp"
#include "tests/support/process_facts.hpp"

namespace slipd::testing {
namespace {

using devices::DeviceSimulator;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kForEverMs = 3'600'000;

// Free at first, long enough for the bias. Then one slip, from which friction is learnt, and then a margin
// of 0.4, in cycles.
json slips_and_holds(int free_ms = 800, int hold_ms = 3000) {
  return {{"noise", 0},
          {"cycle",
           {{{"ms", free_ms}, {"normal_n", 0}, {"shear_n", 0}, {"friction", 0.5}},
            {{"ms", 200}, {"normal_n", {0, 10}}},
            {{"ms", 600}, {"load", {0, 1.1}}},
            {{"ms", 200}, {"shear_n", {5, 3}}},
            {{"ms", hold_ms}}}}};
}

// A simulated device on a thread of its own.
class RunningDevice {
 public:
  enum class Script : std::uint8_t { begun, waits };  // waits: free until press()

  RunningDevice(const devices::DeviceModel& model, std::unique_ptr<devices::Port> port,
                const json& script = slips_and_holds(), Script begin = Script::begun)
      : pressed_(begin == Script::begun),
        simulator_(model, contacts(model, script), std::move(port)),
        thread_([this](std::stop_token stop) { simulator_.run(stop, 100); }) {}
  DeviceSimulator& simulator() { return simulator_; }
  std::string place() { return simulator_.port().place(); }
  void press() { pressed_ = true; }

 private:
  std::vector<devices::Contact> contacts(const devices::DeviceModel& model, const json& script) {
    const json free{{"noise", 0},
                    {"cycle", {{{"ms", kForEverMs}, {"normal_n", 0}, {"shear_n", 0}, {"friction", 0.5}}}}};
    auto all = devices::scripted(model, 100, script);
    const auto waiting = devices::scripted(model, 100, free);
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i] = [this, played = all[i], still = waiting[i]](FrameSlot& slot) {
        (pressed_ ? played : still)(slot);
      };
    }
    return all;
  }

  std::atomic<bool> pressed_;
  DeviceSimulator simulator_;
  std::jthread thread_;
};

json sensor(const std::string& name, const std::string& profile, const json& device, int number = 0) {
  return {
      {"name", name},    {"driver", "modbus"}, {"profile", profile},    {"device", device},
      {"friction", 0.5}, {"rate_hz", 50},      {"stale_after_ms", 300}, {"options", {{"sensor", number}}}};
}

json config_of(const TempFolder& folder, const json& sensors) {
  return config_with(folder, sensors, {{"estimator", {{"method", "moments"}}}});
}

// A state folder of its own, so that no bias of an earlier run is restored.
Program::Environment state_in(const TempFolder& folder) {
  return {{"STATE_DIRECTORY", folder.file("state").string()}};
}

// Waits until the condition holds for all sensors; returns their estimates.
json await(const Daemon& daemon, const std::function<bool(const json&)>& of_each) {
  return daemon.wait_for("gamma", [&](const json& result) {
    for (const json& estimate : result["sensors"]) {
      if (!of_each(estimate)) return false;
    }
    return true;
  });
}

bool holds(const json& estimate) {
  return estimate["state"] == "ok" && std::fabs(estimate["normal_n"].get<double>() - 10) < 0.06 &&
         std::fabs(estimate["shear_n"].get<double>() - 3) < 0.06 &&
         std::fabs(estimate["gamma"].get<double>() - 0.4) < 0.03;
}

auto in_state(const char* state) {
  return [state](const json& estimate) { return estimate["state"] == state; };
}

TEST(ModbusSensors, BothFingersOfAGripperTellTheMarginThroughStallAndUnplugging) {
  const TempFolder folder;
  RunningDevice device(devices::onrobot_rg2ft(), devices::make_modbus_tcp_port(devices::onrobot_rg2ft(), 0));
  const json place = {{"host", "127.0.0.1"}, {"port", std::stoi(device.place())}};
  const Daemon daemon(config_of(folder, json::array({sensor("left", "onrobot-rg2-ft", place, 0),
                                                     sensor("right", "onrobot-rg2-ft", place, 1)})),
                      real_drivers(), state_in(folder));
  await(daemon, holds);
  device.simulator().order("stall 60");
  await(daemon, in_state("stale"));
  await(daemon, holds);
  device.simulator().order("unplug");
  await(daemon, in_state("fault"));
  device.simulator().order("plug");
  await(daemon, holds);
}

// The sensor is free once and then held for the rest of the test, so the bias cannot be measured again.
TEST(ModbusSensors, AReplugInMidGraspBringsTheMarginBackAsItWas) {
  const TempFolder folder;
  RunningDevice device(devices::onrobot_rg2ft(), devices::make_modbus_tcp_port(devices::onrobot_rg2ft(), 0),
                       slips_and_holds(1, kForEverMs), RunningDevice::Script::waits);
  const json place = {{"host", "127.0.0.1"}, {"port", std::stoi(device.place())}};
  const json config = config_of(folder, json::array({sensor("left", "onrobot-rg2-ft", place)}));
  {
    Daemon daemon(config, real_drivers(), state_in(folder));
    await(daemon, in_state("no_contact"));
    device.press();
    await(daemon, holds);
    device.simulator().order("unplug");
    await(daemon, in_state("fault"));
    device.simulator().order("plug");
    await(daemon, holds);
    EXPECT_EQ(daemon.stop(), 0);
  }
  const Daemon daemon(config, real_drivers(), state_in(folder));
  // After the restart only the configured friction is known, because no slip was seen since.
  await(daemon, [](const json& estimate) {
    EXPECT_NE(estimate["state"], "unzeroed");
    return estimate["state"] == "ok" && std::fabs(estimate["normal_n"].get<double>() - 10) < 0.06 &&
           std::fabs(estimate["shear_n"].get<double>() - 3) < 0.06 &&
           std::fabs(estimate["gamma"].get<double>() - 0.4) < estimate["sigma"].get<double>();
  });
  EXPECT_EQ(daemon.client().result("status")["sensors"][0]["zero"]["restored"], true);
}

// The sensor is held for the rest of the test after its one slip, so friction cannot be learnt again.
TEST(ModbusSensors, AReloadInMidGraspKeepsWhatWasLearntUnlessTheSensorIsConfiguredOtherwise) {
  const TempFolder folder;
  RunningDevice device(devices::onrobot_rg2ft(), devices::make_modbus_tcp_port(devices::onrobot_rg2ft(), 0),
                       slips_and_holds(1, kForEverMs), RunningDevice::Script::waits);
  json left = sensor("left", "onrobot-rg2-ft", {{"host", "127.0.0.1"}, {"port", std::stoi(device.place())}});
  left.erase("friction");
  json config = config_of(folder, json::array({left}));
  const Daemon daemon(config, real_drivers(), state_in(folder));
  const auto reload = [&](const char* until) {
    std::ofstream(daemon.config()) << config.dump();
    daemon.program().signal(SIGHUP);
    daemon.wait_for("version",
                    [&](const json&) { return daemon.program().errors().find(until) != std::string::npos; });
  };
  const auto knows = [](const json& estimate) {
    return estimate["state"] == "ok" && std::fabs(estimate["shear_n"].get<double>() - 3) < 0.06 &&
           std::fabs(estimate["gamma"].get<double>() - 0.4) < 0.1;
  };
  await(daemon, in_state("no_contact"));
  device.press();
  await(daemon, knows);
  config["log"] = {{"level", "debug"}};
  config["socket"]["max_clients"] = 5;
  reload("with what it had learnt before the reload");
  await(daemon, knows);
  config["sensors"][0]["rate_hz"] = 40;
  reload("reload: the new configuration is in force\n");
  await(daemon, [&](const json& estimate) {
    return estimate["normal_n"].is_number() && estimate["state"] != "ok" && estimate["gamma"].is_null();
  });
}

TEST(ModbusSensors, AWristSensorOnASerialLineTellsTheMargin) {
  const TempFolder folder;
  const std::string line = folder.file("line").string();
  RunningDevice device(devices::robotiq_ft300(),
                       devices::make_modbus_pty_port(devices::robotiq_ft300(), line), slips_and_holds(),
                       RunningDevice::Script::waits);
  const Daemon daemon(
      config_of(folder, json::array({sensor("wrist", "robotiq-ft300", {{"serial_line", line}})})),
      real_drivers(), state_in(folder));
  await(daemon, in_state("no_contact"));  // its bias is known, however slow the machine is
  device.press();
  await(daemon, holds);
}

TEST(Libraries, OfABusAreInTheProcessOnlyIfASensorIsOnThatBus) {
  const TempFolder folder;
  const Daemon simulated(config_of(folder, json::array({{{"name", "finger"}, {"driver", "sim"}}})),
                         real_drivers());
  const std::string maps = mapped_by(simulated.program().pid());
  EXPECT_THAT(maps, HasSubstr("slipd-driver-sim"));
  for (const char* library : {"libmodbus", "libusb", "libhidapi", "slipd-driver-can", "slipd-driver-modbus",
                              "slipd-driver-usb", "slipd-driver-hid", "slipd-paper"})
    EXPECT_THAT(maps, Not(HasSubstr(library)));

  const TempFolder other;
  const Daemon asked(
      config_of(other, json::array({sensor("wrist", "robotiq-ft300", {{"serial_line", "/nowhere"}})})),
      real_drivers());
  EXPECT_THAT(mapped_by(asked.program().pid()), HasSubstr("libmodbus"));
  EXPECT_THAT(mapped_by(asked.program().pid()), Not(HasSubstr("libusb")));

  const TempFolder third;
  json plugged = sensor("pad", "optoforce", json::object());
  plugged["driver"] = "usb";
  const Daemon usb(config_of(third, json::array({plugged})), real_drivers());
  EXPECT_THAT(mapped_by(usb.program().pid()), HasSubstr("libusb"));
  EXPECT_THAT(mapped_by(usb.program().pid()), Not(HasSubstr("libmodbus")));
}

}  // namespace
}  // namespace slipd::testing
