// The simulated sensor as a device: its options, its pacing, and the control of its normal force.
#include "drivers/sim/sim_driver.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "drivers/pacing.hpp"
#include "tests/drivers/driver_fixture.hpp"

namespace slipd::sim {
namespace {

using nlohmann::json;
using std::chrono::microseconds;
using test::OwnedSlot;
using test::refusal_of;
using test::setup_of;
using ::testing::HasSubstr;

SensorSetup small(json options, double rate_hz = 1000) {
  return setup_of(TaxelLayout::grid(4, 4, 0.003), std::move(options), rate_hz);
}

ReadResult next(DeviceDriver& driver, OwnedSlot& slot) {
  return driver.read({&slot.slot, 1}, std::chrono::seconds(5));
}

TEST(SimDrivers, RunWithoutASingleOption) {
  SimDriver driver({setup_of(TaxelLayout::grid(100, 100, 0.000144), json::object())});
  const auto info = driver.open();
  EXPECT_EQ(info.description, "simulated 100 x 100");
  EXPECT_TRUE(info.simulated);
  OwnedSlot slot(10000);
  EXPECT_EQ(next(driver, slot).status, ReadStatus::frame);
}

TEST(SimDrivers, ShowSlipRegripAndOtherFrictionInTheDefaultCycle) {
  const auto settings = parse_options(small(json::object())).sensor;
  SimulatedSensor sensor(TaxelLayout::grid(4, 4, 0.003), settings);
  int slips = 0, frictions = 0, free = 0;
  Truth last;
  OwnedSlot slot(16);
  for (int ms = 0; ms < 4500; ++ms) {
    sensor.advance(std::chrono::milliseconds(1));
    const Truth now = sensor.truth();
    if (now.gamma == 0 && last.gamma > 0) ++slips;
    if (std::isnan(now.gamma)) ++free;
    if (now.friction != last.friction && !std::isnan(now.friction) && !std::isnan(last.friction)) ++frictions;
    // A rise under load cannot be seen before the next slip: the script lets friction rise only in between.
    if (now.friction > last.friction) {
      ADD_FAILURE() << "friction rises in a grip at " << ms << " ms";
    }
    last = now;
  }
  EXPECT_GE(slips, 3);
  EXPECT_GE(frictions, 1);
  EXPECT_GT(free, 300);
}

TEST(SimDrivers, HandOutFramesWhenTheyAreDueAndNotBefore) {
  SimDriver driver({small(json::object(), 2000)});
  driver.open();
  OwnedSlot slot(16);
  std::int64_t first_ns = 0;
  for (int i = 0; i < 50; ++i) {
    ASSERT_EQ(next(driver, slot).status, ReadStatus::frame);
    EXPECT_GE(monotonic_ns(), slot.slot.time_ns);
    if (i == 0) first_ns = slot.slot.time_ns - static_cast<std::int64_t>(slot.slot.sequence) * 500000;
    // Absolute times: however late one was taken, the next is where it belongs.
    EXPECT_EQ(slot.slot.time_ns - first_ns, static_cast<std::int64_t>(slot.slot.sequence) * 500000);
  }
}

TEST(SimDrivers, ReturnWithoutAFrameWhenTheTimeGivenIsShorterThanTheWait) {
  SimDriver driver({small(json::object(), 0.01)});
  driver.open();
  OwnedSlot slot(16);
  EXPECT_EQ(driver.read({&slot.slot, 1}, microseconds(100)).status, ReadStatus::timeout);
}

TEST(SimDrivers, SkipFramesWithAGapInTheSequenceIfNotRead) {
  SimDriver driver({small(json::object(), 100000)});
  driver.open();
  OwnedSlot slot(16);
  ASSERT_EQ(next(driver, slot).status, ReadStatus::frame);
  const auto before = slot.slot.sequence;
  ::usleep(150000);  // what is tested is that time passes without a read
  ASSERT_EQ(next(driver, slot).status, ReadStatus::frame);
  EXPECT_GT(slot.slot.sequence - before, 10000U);
  EXPECT_EQ(slot.slot.device_time_ns, static_cast<std::int64_t>(slot.slot.sequence + 1) * 10000);
}

TEST(SimDrivers, BringLateFramesInOrder) {
  SimDriver driver({small({{"late_ms", 5}}, 1000)});
  driver.open();
  OwnedSlot slot(16);
  std::int64_t last_ns = 0;
  std::uint64_t last_sequence = 0;
  bool late = false;
  for (int i = 0; i < 50; ++i) {
    ASSERT_EQ(next(driver, slot).status, ReadStatus::frame);
    if (i > 0) {
      EXPECT_GT(slot.slot.sequence, last_sequence);
    }
    EXPECT_GT(slot.slot.time_ns, last_ns);
    last_sequence = slot.slot.sequence;
    late = late || slot.slot.time_ns - last_ns > 1500000;
    last_ns = slot.slot.time_ns;
  }
  EXPECT_TRUE(late);
}

TEST(SimDrivers, CarrySeveralSensorsEachAtItsOwnRate) {
  SimDriver driver({small({{"speed", 0}}, 1000), small({{"speed", 0}, {"seed", 2}}, 250)});
  EXPECT_EQ(driver.open().sensors.size(), 2U);
  OwnedSlot a(16), b(16);
  FrameSlot slots[] = {a.slot, b.slot};
  std::int64_t last_ns = 0;
  for (int i = 0; i < 100; ++i) {
    const ReadResult result = driver.read(slots, microseconds(0));
    ASSERT_EQ(result.status, ReadStatus::frame);
    EXPECT_GE(slots[result.sensor].time_ns, last_ns) << "the sensors of a device share one clock";
    last_ns = slots[result.sensor].time_ns;
  }
  EXPECT_EQ(slots[0].sequence + 1, 4 * (slots[1].sequence + 1));
}

TEST(SimDrivers, AtSpeedZeroArePacedByTheConsumerAndLeaveNothingOut) {
  const json options = {{"speed", 0}, {"noise", 0.01}};
  SimDriver driver({small(options, 10)});  // a hundred frames are ten seconds of the simulated clock
  EXPECT_EQ(driver.open().sensors[0].rate_hz, 10);
  EXPECT_TRUE(driver.paced_by_consumer());
  EXPECT_FALSE(SimDriver({small(json::object())}).paced_by_consumer());
  const auto settings = parse_options(small(options, 10)).sensor;
  SimulatedSensor sensed(TaxelLayout::grid(4, 4, 0.003), settings);
  OwnedSlot slot(16), expected(16);
  std::int64_t first_ns = 0;
  for (std::uint64_t i = 0; i < 100; ++i) {
    ASSERT_EQ(driver.read({&slot.slot, 1}, microseconds(0)).status, ReadStatus::frame);
    if (i == 0) first_ns = slot.slot.time_ns;
    EXPECT_EQ(slot.slot.sequence, i);
    EXPECT_EQ(slot.slot.time_ns - first_ns, static_cast<std::int64_t>(i) * 100'000'000);
    sensed.advance(std::chrono::milliseconds(100));
    ASSERT_TRUE(sensed.sample(expected.slot));
    EXPECT_EQ(slot.slot.device_time_ns, expected.slot.device_time_ns);
    EXPECT_EQ(slot.memory, expected.memory);
  }
}

TEST(SimDrivers, AtSpeedZeroFramesAreLostAndLateAsInRealTime) {
  SimDriver driver({small({{"speed", 0}, {"drop", 0.5}, {"late_ms", 5}}, 1000)});
  driver.open();
  OwnedSlot slot(16);
  std::int64_t last_ns = 0;
  bool late = false;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_EQ(driver.read({&slot.slot, 1}, microseconds(0)).status, ReadStatus::frame);
    EXPECT_GT(slot.slot.time_ns, last_ns);
    late = late || (i > 0 && (slot.slot.time_ns - last_ns) % 1'000'000 != 0);
    last_ns = slot.slot.time_ns;
  }
  EXPECT_TRUE(late);
  EXPECT_NEAR(static_cast<double>(slot.slot.sequence), 2000, 200);
}

TEST(SimDrivers, RefuseInvalidOptionsWithTheRemedy) {
  auto flat = small(json::object());
  flat.skin_radius_m = std::numeric_limits<double>::infinity();
  EXPECT_THAT(refusal_of([&] { SimDriver({flat}); }), HasSubstr("a flat skin needs a round object"));
  flat.options = {{"object", {{"radius_mm", 20}}}};
  EXPECT_EQ(refusal_of([&] { SimDriver({flat}); }), "");
  EXPECT_THAT(refusal_of([&] { SimDriver({small({{"object", {{"radius_mm", -5}}}})}); }), HasSubstr("left"));
  const json both = {{"cycle", {{{"ms", 5}, {"load", {0, 1}}, {"shear_n", 1}}}}};
  EXPECT_THAT(refusal_of([&] { SimDriver({small(both)}); }), HasSubstr("cycle/0: give shear_n or load"));
  EXPECT_THAT(refusal_of([&] { SimDriver({small({{"seed", "x"}})}); }), HasSubstr("schema"));
  EXPECT_THAT(refusal_of([&] {
                SimDriver({small({{"speed", 0}, {"grip_input", "/tmp/grip"}})});
              }),
              HasSubstr("grip_input needs speed 1"));
  EXPECT_THAT(refusal_of([&] {
                SimDriver({small({{"speed", 0}}), small(json::object())});
              }),
              HasSubstr("speed must be the same"));
  EXPECT_THAT(refusal_of([&] { SimDriver({small(json::object(), 0)}); }), HasSubstr("rate_hz"));
}

class GripInputs : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = std::filesystem::temp_directory_path() / ("slipd-grip-" + std::to_string(::getpid()));
  }
  void TearDown() override { std::filesystem::remove(path_); }
  void send(const std::string& datagram) const {
    const int fd = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, path_.c_str());
    EXPECT_EQ(::sendto(fd, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&address),
                       sizeof address),
              static_cast<ssize_t>(datagram.size()));
    ::close(fd);
  }
  std::filesystem::path path_;
};

TEST_F(GripInputs, SetTheNormalForceOfTheNextFrame) {
  SimDriver driver(
      {small({{"grip_input", path_.string()},
              {"noise", 0},
              {"cycle", {{{"ms", 100}, {"normal_n", 1}, {"shear_n", 0.25}, {"friction", 0.5}}}}})});
  driver.open();
  OwnedSlot slot(16);
  ASSERT_EQ(next(driver, slot).status, ReadStatus::frame);
  EXPECT_NEAR(slot.slot.truth.gamma, 0.5, 1e-12);
  send("{\"normal_n\": 1.5}");
  send("2.5\n");
  send("nonsense");
  ASSERT_EQ(next(driver, slot).status, ReadStatus::frame);
  EXPECT_NEAR(slot.slot.truth.gamma, 0.8, 1e-12);
  driver.close();
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(GripInputs, ReplaceASocketWithoutAnOwnerAndNothingElse) {
  std::filesystem::create_directory(path_);
  EXPECT_THAT(refusal_of([&] { GripInput input(path_); }), HasSubstr(path_.string()));
  std::filesystem::remove(path_);
  {
    const GripInput first(path_);
    EXPECT_THAT(refusal_of([&] { GripInput second(path_); }), HasSubstr("in use"));
  }
  const int orphan = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, path_.c_str());
  ASSERT_EQ(::bind(orphan, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ::close(orphan);
  EXPECT_EQ(refusal_of([&] { GripInput input(path_); }), "");
}

TEST(GripDatagrams, AreANumberOrAnObjectWithOneAndNothingElse) {
  EXPECT_EQ(parse_grip(" 2.5 \n"), 2.5);
  EXPECT_EQ(parse_grip("1e-3"), 1e-3);
  EXPECT_EQ(parse_grip("{ \"normal_n\" : 0 }"), 0.0);
  for (const char* bad : {"", "x", "-1", "nan", "inf", "1 2", "{}", "{\"normal_n\":}", "{\"normal_n\":1",
                          "{\"normal\":1}", "1}", "[1]"}) {
    EXPECT_EQ(parse_grip(bad), std::nullopt) << bad;
  }
}

}  // namespace
}  // namespace slipd::sim
