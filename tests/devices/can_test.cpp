// A simulated CAN device on a pair of sockets: the host's end gets the same frames as from a SocketCAN
// interface.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/can.h>
#include <sys/socket.h>

#include <sstream>

#include "tests/devices/contacts.hpp"

namespace slipd::devices {
namespace {

using ::testing::HasSubstr;

class CanDevice : public ::testing::Test {
 protected:
  CanDevice() {
    int pair[2];
    checked(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair), "socketpair");
    host_ = Fd(pair[0]);
    simulator_ = std::make_unique<DeviceSimulator>(xela_xr1944(), pattern(xela_xr1944()),
                                                   make_can_port(xela_xr1944(), pair[1]), &truth_);
  }

  void start() {
    can_frame command{};
    command.can_id = 0x201;
    command.len = 2;
    command.data[0] = 0x07;
    ASSERT_EQ(::send(host_.get(), &command, sizeof command, 0), static_cast<ssize_t>(sizeof command));
    simulator_->port().serve();
  }

  std::vector<can_frame> received() {
    std::vector<can_frame> frames;
    for (can_frame frame{}; ::recv(host_.get(), &frame, sizeof frame, MSG_DONTWAIT) > 0;)
      frames.push_back(frame);
    return frames;
  }

  std::ostringstream truth_;
  Fd host_;
  std::unique_ptr<DeviceSimulator> simulator_;
};

TEST_F(CanDevice, IsSilentUntilItIsStarted) {
  simulator_->step();
  EXPECT_TRUE(received().empty());
  start();
  simulator_->step();
  const auto frames = received();
  ASSERT_EQ(frames.size(), 16);
  EXPECT_EQ(frames[0].can_id, 0x710);
  EXPECT_EQ(frames[0].len, 7);
  EXPECT_EQ(frames[15].can_id, 0x71F);
}

TEST_F(CanDevice, MisbehavesForTheOrderedNumberOfScans) {
  start();
  simulator_->order("lose 2");
  for (const std::size_t expected : {15U, 15U, 16U}) {
    simulator_->step();
    EXPECT_EQ(received().size(), expected);
  }
}

TEST_F(CanDevice, StallsAndComesBack) {
  start();
  simulator_->order_at(1, "stall 2");
  for (const std::size_t expected : {16U, 0U, 0U, 16U}) {
    simulator_->step();
    EXPECT_EQ(received().size(), expected);
  }
}

TEST_F(CanDevice, MustBeStartedAgainAfterItWasUnplugged) {
  start();
  simulator_->order("unplug");
  simulator_->step();
  EXPECT_TRUE(received().empty());
  simulator_->order("plug");
  simulator_->step();
  EXPECT_TRUE(received().empty()) << "it has forgotten that it was started";
  start();
  simulator_->step();
  EXPECT_EQ(received().size(), 16);
}

TEST_F(CanDevice, RecordsFramesAndOrders) {
  start();
  simulator_->step();
  simulator_->order("garbage\n");
  simulator_->step();
  // 16 taxels of 4.7 mm: 1000 Pa x (1 + … + 16) x 22.09 mm² = 3.00424 N.
  EXPECT_THAT(truth_.str(),
              HasSubstr(R"("gamma":null,"friction":null,"normal_n":3.00424,"shear_n":1.67942)"));
  EXPECT_THAT(truth_.str(), HasSubstr(R"({"scan":1,"order":"garbage 1"})"));
}

TEST_F(CanDevice, EndsOnTheOrderQuit) {
  EXPECT_TRUE(simulator_->step());
  simulator_->order("quit");
  EXPECT_FALSE(simulator_->step());
}

}  // namespace
}  // namespace slipd::devices
