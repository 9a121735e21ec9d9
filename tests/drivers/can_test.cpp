// The CAN driver on a bus that is a pair of sockets, with a simulated board at the other end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include "drivers/can/can_driver.hpp"
#include "tests/devices/contacts.hpp"
#include "tests/drivers/driver_fixture.hpp"
#include "tests/support/heap_count.hpp"

namespace slipd::can {
namespace {

using namespace std::chrono_literals;
using devices::DeviceSimulator;
using testing::HasSubstr;

SensorSetup board(int number, const std::string& profile = "xela-xr1944") {
  SensorSetup setup = test::setup_of(TaxelLayout::grid(100, 100, 0.001), {{"board", number}});
  setup.profile = profile;
  setup.device = {{"interface", "can0"}};
  return setup;
}

class CanDriverOnABus : public testing::Test {
 protected:
  CanDriverOnABus()
      : driver_({board(1)},
                [this](const std::string&, const std::vector<std::uint32_t>& ids) {
                  ids_ = ids;
                  int pair[2];
                  devices::checked(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair),
                                   "socketpair");
                  const auto& model = devices::xela_xr1944();
                  simulator_.reset();
                  simulator_ = std::make_unique<DeviceSimulator>(model, devices::pattern(model),
                                                                 devices::make_can_port(model, pair[1]));
                  bus_ = pair[0];
                  return Socket(pair[0]);
                }),
        slot_(16) {}

  ReadResult read() { return driver_.read(std::span(&slot_.slot, 1), 5ms); }

  // Whether packets wait for the driver. On a busy machine a read may time out before it has taken them all.
  bool packets_wait() const {
    pollfd bus{.fd = bus_, .events = POLLIN, .revents = 0};
    return ::poll(&bus, 1, 0) == 1;
  }

  // Waits until the driver has sent its start messages and the board has received them.
  void start() {
    driver_.open();
    EXPECT_EQ(read().status, ReadStatus::timeout);
    simulator_->port().serve();
  }

  std::vector<ReadStatus> scan() {
    simulator_->step();
    std::vector<ReadStatus> seen;
    while (packets_wait()) {
      const ReadStatus status = read().status;
      if (status != ReadStatus::timeout) seen.push_back(status);
    }
    return seen;
  }

  std::vector<std::uint32_t> ids_;
  int bus_ = -1;  // the driver's end
  std::unique_ptr<DeviceSimulator> simulator_;
  CanDriver driver_;
  test::OwnedSlot slot_;
};

TEST_F(CanDriverOnABus, StartsTheBoardAndReadsItsScans) {
  const DeviceInfo info = driver_.open();
  ASSERT_EQ(info.sensors.size(), 1);
  EXPECT_EQ(info.sensors[0].layout, TaxelLayout::grid(4, 4, 0.0047)) << "the profile's, not the setup's";
  EXPECT_TRUE(std::isinf(info.sensors[0].skin->radius_m));
  EXPECT_EQ(ids_.size(), 16) << "filters for every identifier of the scan and no other";
  start();
  const auto before_ns = std::chrono::steady_clock::now().time_since_epoch() / 1ns;
  EXPECT_THAT(scan(), testing::ElementsAre(ReadStatus::frame));
  EXPECT_NEAR(slot_.slot.normal_pa[15], 16000, 20.1);
  EXPECT_GE(slot_.slot.time_ns, before_ns);
}

TEST_F(CanDriverOnABus, DropsScansThatAreNotWholeAndGoesOn) {
  start();
  for (const char* order : {"lose", "reorder", "repeat", "shorten", "lengthen", "garbage"}) {
    scan();
    simulator_->order(order);
    EXPECT_THAT(scan(), testing::Each(testing::AnyOf(ReadStatus::corrupt, ReadStatus::frame))) << order;
    scan();
    const std::uint64_t sequence = slot_.slot.sequence;
    EXPECT_THAT(scan(), testing::ElementsAre(ReadStatus::frame)) << order;
    EXPECT_EQ(slot_.slot.sequence, sequence + 1) << order;
    EXPECT_NEAR(slot_.slot.normal_pa[15], 16000, 20.1) << order;
  }
}

TEST_F(CanDriverOnABus, StartsABoardAgainThatLostItsPower) {
  start();
  scan();
  simulator_->order("unplug");
  EXPECT_TRUE(scan().empty());
  simulator_->order("plug");
  std::vector<ReadStatus> seen;
  const auto give_up = std::chrono::steady_clock::now() + 5min;
  while (seen.empty() && std::chrono::steady_clock::now() < give_up) {
    driver_.read(std::span(&slot_.slot, 1), 20ms);
    simulator_->port().serve();
    seen = scan();
  }
  EXPECT_THAT(seen, testing::Contains(ReadStatus::frame));
}

TEST_F(CanDriverOnABus, SaysSoWhenTheBusIsGone) {
  start();
  simulator_.reset();
  EXPECT_EQ(read().status, ReadStatus::disconnected);
  driver_.close();
  driver_.close();
}

TEST_F(CanDriverOnABus, AllocatesNothingWhileReading) {
  start();
  scan();
  std::uint64_t allocated = 0;
  for (int i = 0; i < 50; ++i) {
    simulator_->step();
    const std::uint64_t before = test::allocations();
    ReadStatus status = ReadStatus::timeout;
    while (status == ReadStatus::timeout && packets_wait()) status = read().status;
    allocated += test::allocations() - before;
    EXPECT_EQ(status, ReadStatus::frame);
  }
  EXPECT_EQ(allocated, 0);
}

TEST_F(CanDriverOnABus, HonoursItsTimeOut) {
  driver_.open();
  const auto begun = std::chrono::steady_clock::now();
  EXPECT_EQ(driver_.read(std::span(&slot_.slot, 1), 20ms).status, ReadStatus::timeout);
  EXPECT_GE(std::chrono::steady_clock::now() - begun, 20ms);
}

TEST(CanDriver, RefusesWhatCannotWork) {
  SensorSetup nowhere = board(1);
  nowhere.device = nlohmann::json::object();
  EXPECT_THAT(test::refusal_of([&] { CanDriver{{nowhere}}; }), HasSubstr("{\"interface\": \"can0\"}"));
  EXPECT_THAT(test::refusal_of([] {
                CanDriver({board(2), board(2)});
              }),
              HasSubstr("board 2 is another sensor's already"));
  EXPECT_THAT(test::refusal_of([] { CanDriver({board(1, "robotiq-ft300")}); }),
              HasSubstr("is for driver modbus"));
  EXPECT_THAT(test::refusal_of([] { CanDriver({board(1)}).open(); }), HasSubstr("CAN interface can0"));
}

}  // namespace
}  // namespace slipd::can
