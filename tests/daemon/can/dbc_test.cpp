// The DBC of a running configuration: each sensor and grasp has its messages, everything else is as shipped.
#include "daemon/can/dbc.hpp"

#include <gtest/gtest.h>

#include "embedded/slipd_dbc.hpp"
#include "tests/support/dbc.hpp"

namespace slipd::can {
namespace {

CanSettings can_at(std::uint32_t base, bool extended, bool fd) {
  CanSettings can;
  can.interface = "can7";
  can.base_id = base;
  can.extended = extended;
  can.fd = fd;
  can.period = std::chrono::milliseconds(4);
  return can;
}

TEST(CanDbc, EverySubjectHasItsMessages) {
  const auto messages =
      testing::read_dbc(dbc_text(can_at(0x100, false, false), {"sensor left", "sensor right", "grasp both"}));
  ASSERT_EQ(messages.size(), 7U);
  const auto shipped = testing::read_dbc(std::string(slipd_dbc));
  const char* sources[] = {"sensor left", "sensor right", "grasp both"};
  for (std::uint32_t i = 0; i < 3; ++i) {
    const auto& estimate = messages.at(0x100 + i);
    EXPECT_EQ(estimate.name, "SLIP_ESTIMATE_" + std::to_string(i));
    EXPECT_NE(estimate.comment.find(sources[i]), std::string::npos);
    EXPECT_EQ(estimate.attributes.at("GenMsgCycleTime"), 4);
    EXPECT_EQ(messages.at(0x120 + i).name, "SLIP_ALERT_" + std::to_string(i));
    EXPECT_EQ(messages.at(0x120 + i).attributes.at("GenMsgCycleTime"), 50);
    for (const auto& [name, signal] : shipped.at(0x5A0).signals) {
      EXPECT_EQ(estimate.signals.at(name).start, signal.start);
      EXPECT_EQ(estimate.signals.at(name).values, signal.values);
      EXPECT_EQ(estimate.signals.at(name).comment, signal.comment);
    }
  }
  EXPECT_EQ(messages.at(0x13F).name, "SLIP_HEARTBEAT");
}

TEST(CanDbc, SlidingHasMessagesWhereItIsConfigured) {
  CanSettings can = can_at(0x100, true, true);
  can.sliding = true;
  const auto messages = testing::read_dbc(dbc_text(can, {"sensor left", "grasp both"}));
  ASSERT_EQ(messages.size(), 7U);
  for (std::uint32_t i = 0; i < 2; ++i) {
    const auto& sliding = messages.at(0x140 + i);
    EXPECT_EQ(sliding.name, "SLIP_SLIDING_" + std::to_string(i));
    EXPECT_NE(sliding.comment.find(i == 0 ? "sensor left" : "grasp both"), std::string::npos);
    EXPECT_EQ(sliding.attributes.at("GenMsgCycleTime"), 4);
    EXPECT_EQ(sliding.attributes.at("VFrameFormat"), 15);
  }
}

TEST(CanDbc, LongIdentifiersAndFdFramesAreMarked) {
  const auto format = [](bool extended, bool fd) {
    const auto messages = testing::read_dbc(dbc_text(can_at(0x12300, extended, fd), {"sensor left"}));
    EXPECT_EQ(messages.at(0x12300).extended, extended);
    EXPECT_EQ(messages.at(0x1233F).extended, extended);
    return messages.at(0x12300).attributes.at("VFrameFormat");
  };
  EXPECT_EQ(format(false, false), 0);
  EXPECT_EQ(format(true, false), 1);
  EXPECT_EQ(format(false, true), 14);
  EXPECT_EQ(format(true, true), 15);
}

TEST(CanDbc, TheDefaultIdentifiersHaveTheDbcAsShipped) {
  CanSettings can = can_at(0x5A0, false, false);
  can.sliding = true;
  can.period = std::chrono::milliseconds(10);
  const auto made = testing::read_dbc(dbc_text(can, {"sensor 0 of the configuration"}));
  const auto shipped = testing::read_dbc(std::string(slipd_dbc));
  ASSERT_EQ(made.size(), shipped.size());
  for (const auto& [id, message] : shipped) {
    EXPECT_EQ(made.at(id).comment, message.comment);
    EXPECT_EQ(made.at(id).attributes, message.attributes);
  }
}

TEST(CanDbc, AnyNameGivesAValidFile) {
  Settings settings;
  settings.sensors.push_back({.setup = {.name = "le\"ft\n",
                                        .layout = TaxelLayout::grid(4, 4, 1e-3),
                                        .profile = {},
                                        .device = {},
                                        .options = {}},
                              .driver = "sim",
                              .friction = {},
                              .gain = {}});
  settings.grasps.push_back({"both", {"left"}, {}});
  EXPECT_EQ(source_names(settings), (std::vector<std::string>{"sensor le'ft'", "grasp both"}));
}

}  // namespace
}  // namespace slipd::can
