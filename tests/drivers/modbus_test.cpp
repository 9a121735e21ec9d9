// The Modbus driver and simulated slaves: TCP on loopback, RTU on a pseudo-terminal.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "drivers/modbus/modbus_driver.hpp"
#include "tests/devices/contacts.hpp"
#include "tests/drivers/driver_fixture.hpp"
#include "tests/support/heap_count.hpp"
#include "tests/support/patience.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::modbus {
namespace {

using namespace std::chrono_literals;
using devices::DeviceSimulator;
using ::testing::HasSubstr;

constexpr double kRg2ftArea = 0.018 * 0.018, kFt300Area = 0.02 * 0.02;

// A device that runs on a thread of its own.
class Running {
 public:
  Running(const devices::DeviceModel& model, std::unique_ptr<devices::Port> port)
      : simulator_(model, devices::pattern(model), std::move(port)),
        thread_([this](std::stop_token stop) { simulator_.run(stop, 500); }) {}
  DeviceSimulator& simulator() { return simulator_; }
  int port() { return std::stoi(simulator_.port().place()); }

 private:
  DeviceSimulator simulator_;
  std::jthread thread_;
};

Running rg2ft() {
  return {devices::onrobot_rg2ft(), devices::make_modbus_tcp_port(devices::onrobot_rg2ft(), 0)};
}

SensorSetup sensor(const std::string& profile, nlohmann::json device, int number = 0) {
  SensorSetup setup = test::setup_of(TaxelLayout::grid(100, 100, 0.001), {{"sensor", number}});
  setup.profile = profile;
  setup.device = std::move(device);
  return setup;
}

// A driver with its slots, read until something is seen.
class Host {
 public:
  explicit Host(std::vector<SensorSetup> setups) : driver(setups) {
    for (std::size_t i = 0; i < setups.size(); ++i) owned_.emplace_back(1);
    for (auto& owned : owned_) slots.push_back(owned.slot);
  }
  ReadResult read() { return driver.read(slots, 50ms); }
  bool sees(ReadStatus wanted) {
    const auto give_up = std::chrono::steady_clock::now() + testing::kPatience;
    while (std::chrono::steady_clock::now() < give_up) {
      if (read().status == wanted) return true;
    }
    return false;
  }

 private:
  std::vector<test::OwnedSlot> owned_;

 public:
  std::vector<FrameSlot> slots;
  ModbusDriver driver;
};

// The pattern presses the first sensor with 1000 Pa and the second with 1100, which is half a newton's tenth.
TEST(ModbusDriver, ReadsBothFingersFromOneAnswer) {
  Running device = rg2ft();
  const nlohmann::json place = {{"host", "127.0.0.1"}, {"port", device.port()}};
  Host host({sensor("onrobot-rg2-ft", place, 1), sensor("onrobot-rg2-ft", place, 0)});
  const DeviceInfo info = host.driver.open();
  ASSERT_EQ(info.sensors.size(), 2);
  EXPECT_EQ(info.sensors[0].sensor_class, SensorClass::wrench);
  while (host.slots[0].normal_pa[0] == 0) ASSERT_TRUE(host.sees(ReadStatus::frame));
  std::vector<int> seen(2, 0);
  for (int i = 0; i < 20; ++i) {
    ReadResult result = host.read();
    while (result.status != ReadStatus::frame) result = host.read();
    ++seen[result.sensor];
  }
  EXPECT_NEAR(seen[0], seen[1], 1);
  EXPECT_NEAR(host.slots[0].normal_pa[0] * kRg2ftArea, 0.4, 1e-6) << "1100 Pa to a tenth of a newton";
  EXPECT_NEAR(host.slots[1].normal_pa[0] * kRg2ftArea, 0.3, 1e-6);
}

TEST(ModbusDriver, SpeaksRtuOverASerialLine) {
  const testing::TempFolder folder;
  const std::string line = (folder.path() / "line").string();
  Running device(devices::robotiq_ft300(), devices::make_modbus_pty_port(devices::robotiq_ft300(), line));
  Host host({sensor("robotiq-ft300", {{"serial_line", line}})});
  EXPECT_THAT(host.driver.open().description, HasSubstr("unit 9"));
  while (host.slots[0].normal_pa[0] == 0) ASSERT_TRUE(host.sees(ReadStatus::frame));
  EXPECT_NEAR(host.slots[0].normal_pa[0] * kFt300Area, 0.4, 1e-6);
  EXPECT_NEAR(host.slots[0].shear_y_pa[0] * kFt300Area, -0.1, 1e-6);
}

TEST(ModbusDriver, DropsAnswersThatAreNoScanAndGoesOn) {
  Running device = rg2ft();
  Host host({sensor("onrobot-rg2-ft", {{"host", "127.0.0.1"}, {"port", device.port()}})});
  host.driver.open();
  ASSERT_TRUE(host.sees(ReadStatus::frame));
  device.simulator().order("shorten 20");
  EXPECT_TRUE(host.sees(ReadStatus::corrupt));
  EXPECT_TRUE(host.sees(ReadStatus::frame));
}

TEST(ModbusDriver, ReportsTimeOutsWhileTheDeviceIsSilentAndReadsOnAfterwards) {
  Running device = rg2ft();
  Host host({sensor("onrobot-rg2-ft", {{"host", "127.0.0.1"}, {"port", device.port()}})});
  host.driver.open();
  ASSERT_TRUE(host.sees(ReadStatus::frame));
  device.simulator().order("stall 100");  // 200 ms
  for (int i = 0; i < 40; ++i) EXPECT_NE(host.read().status, ReadStatus::disconnected);
  EXPECT_TRUE(host.sees(ReadStatus::frame));
}

TEST(ModbusDriver, SaysWhenTheDeviceIsGoneAndOpensItAgainWhenItIsBack) {
  Running device = rg2ft();
  Host host({sensor("onrobot-rg2-ft", {{"host", "127.0.0.1"}, {"port", device.port()}})});
  host.driver.open();
  ASSERT_TRUE(host.sees(ReadStatus::frame));
  device.simulator().order("unplug");
  ASSERT_TRUE(host.sees(ReadStatus::disconnected));
  host.driver.close();
  EXPECT_THAT(test::refusal_of([&] { host.driver.open(); }), HasSubstr("is the device on"));
  device.simulator().order("plug");
  const auto give_up = std::chrono::steady_clock::now() + testing::kPatience;
  while (!test::refusal_of([&] { host.driver.open(); }).empty() && std::chrono::steady_clock::now() < give_up)
    std::this_thread::yield();
  EXPECT_TRUE(host.sees(ReadStatus::frame));
}

TEST(ModbusDriver, SaysWhichRegisterADeviceOfAnotherProfileRefuses) {
  Running device = rg2ft();
  Host host({sensor("robotiq-ft300", {{"host", "127.0.0.1"}, {"port", device.port()}, {"unit", 65}})});
  EXPECT_THAT(test::refusal_of([&] { host.driver.open(); }),
              HasSubstr("unit 65: answers, but refuses register 180: Illegal data address: wrong profile"));
}

TEST(ModbusDriver, SaysWhatADeviceRefusesThatAnsweredBefore) {
  Running device = rg2ft();
  Host host({sensor("onrobot-rg2-ft", {{"host", "127.0.0.1"}, {"port", device.port()}})});
  host.driver.open();
  ASSERT_TRUE(host.sees(ReadStatus::frame));
  device.simulator().order("shorten 1000000");
  ASSERT_TRUE(host.sees(ReadStatus::changed));
  host.driver.close();
  EXPECT_THAT(test::refusal_of([&] { host.driver.open(); }),
              HasSubstr("refuses register 257: Illegal data address"));
}

TEST(ModbusDriver, KeepsTheProfilesRateAndItsSequence) {
  Running device = rg2ft();
  Host host({sensor("onrobot-rg2-ft", {{"host", "127.0.0.1"}, {"port", device.port()}})});
  host.driver.open();
  ASSERT_TRUE(host.sees(ReadStatus::frame));
  const std::int64_t begun_ns = host.slots[0].time_ns;
  const std::uint64_t first = host.slots[0].sequence;
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(host.sees(ReadStatus::frame));
  EXPECT_EQ(host.slots[0].sequence, first + 20);
  EXPECT_GE(host.slots[0].time_ns - begun_ns, 150'000'000) << "twenty periods of 10 ms, the first one late";
}

TEST(ModbusDriver, AllocatesNothingWhileReading) {
  Running device = rg2ft();
  Host host({sensor("onrobot-rg2-ft", {{"host", "127.0.0.1"}, {"port", device.port()}})});
  host.driver.open();
  ASSERT_TRUE(host.sees(ReadStatus::frame));
  const std::uint64_t before = test::allocations();
  for (int i = 0; i < 20; ++i) host.read();
  EXPECT_EQ(test::allocations(), before);
}

TEST(ModbusDriver, RefusesWhatCannotWork) {
  const auto said = [](nlohmann::json device, int number) {
    return test::refusal_of([&] { ModbusDriver({sensor("robotiq-ft300", std::move(device), number)}); });
  };
  EXPECT_THAT(said(nlohmann::json::object(), 0), HasSubstr("\"serial_line\": \"/dev/ttyUSB0\""));
  EXPECT_THAT(said({{"host", "h"}, {"serial_line", "/dev/x"}}, 0), HasSubstr("device: expected"));
  EXPECT_THAT(said({{"host", 5}}, 0), HasSubstr("device: expected"));
  EXPECT_THAT(said({{"serial_line", "/dev/x"}}, 1), HasSubstr("sensor 1 is not there; the device has 1"));
}

}  // namespace
}  // namespace slipd::modbus
