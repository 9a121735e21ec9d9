// examples/slip_can.h: the frames that slipd encodes, damaged, repeated, late and lost, against the receiver
// of the simulated gripper, which decodes them by slipd's own table of signals.
#include "examples/slip_can.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "daemon/can/encode.hpp"
#include "tests/support/gripper/margin_receiver.hpp"

namespace slipd::testing {
namespace {

using namespace std::chrono_literals;
using gripper::MarginReceiver;
using gripper::Time;

constexpr std::uint32_t kBase = 0x5A0;
constexpr auto kPeriod = 10ms;
constexpr double kPeriod_s = 0.01;

class SlipCan : public ::testing::Test {
 protected:
  SlipCan() { slip_.accept_simulated = true; }
  int hear(const can::Message& message) {
    return slip_can_hear(&slip_, message.id, message.data.data(), 8, now_s_);
  }
  can::Message estimate(double gamma, State state = State::ok, Alert alert = Alert::none) {
    Estimate made;
    made.state = state;
    made.gamma = gamma;
    made.alert = alert;
    made.grip_increase_n = 1.5;
    return can::encode_estimate(kBase, made, true, counter_++);
  }
  void hear_some() {
    for (int i = 0; i < 5; ++i) {
      now_s_ += kPeriod_s;
      hear(estimate(0.7));
    }
  }
  slip_can_reading now() const { return slip_can_now(&slip_, now_s_); }

  slip_can slip_ = slip_can_begin(kBase, 0, kPeriod_s);
  double now_s_ = 1000;
  unsigned counter_ = 0;
};

TEST_F(SlipCan, NothingHeardIsStale) {
  EXPECT_EQ(now().state, SLIP_CAN_STALE);
  EXPECT_TRUE(std::isnan(now().gamma));
  EXPECT_EQ(now().alert, SLIP_CAN_UNKNOWN);
}

TEST_F(SlipCan, NoAlertIsUnknownInSilenceAndARaisedOneStands) {
  for (const auto& [sent, after] : {std::pair{Alert::none, SLIP_CAN_UNKNOWN}, {Alert::slip, SLIP_CAN_SLIP}}) {
    hear_some();
    hear(estimate(0.7, State::ok, sent));
    EXPECT_EQ(now().alert, static_cast<int>(sent));
    now_s_ += 4 * kPeriod_s;
    EXPECT_EQ(now().state, SLIP_CAN_STALE);
    EXPECT_EQ(now().alert, after);
    hear(estimate(0.7, State::ok, sent));  // one that waited while the bus was interrupted
    EXPECT_EQ(now().alert, after);
  }
}

TEST_F(SlipCan, AMarginIsThereAfterFramesThatMayBeOldAndEndsWithItsDeadline) {
  hear_some();
  EXPECT_EQ(now().state, SLIP_CAN_OK);
  EXPECT_NEAR(now().gamma, 0.7, 1e-9);
  now_s_ += 3.1 * kPeriod_s;
  EXPECT_EQ(now().state, SLIP_CAN_STALE);
  EXPECT_TRUE(std::isnan(now().gamma));
  hear(estimate(0.7));
  EXPECT_EQ(now().state, SLIP_CAN_STALE) << "the first frames after a silence may have waited in a queue";
}

TEST_F(SlipCan, ASimulatedSensorIsAcceptedOnDemandOnly) {
  slip_.accept_simulated = false;
  hear_some();
  EXPECT_EQ(now().state, SLIP_CAN_STALE);
}

TEST_F(SlipCan, EveryStateButOkHasNoMargin) {
  for (int state = 1; state <= static_cast<int>(State::fault); ++state) {
    hear_some();
    hear(estimate(0.7, static_cast<State>(state)));
    EXPECT_EQ(now().state, state);
    EXPECT_TRUE(std::isnan(now().gamma)) << state;
  }
}

TEST_F(SlipCan, AnAlertIsKnownAtOnceWithTheForceToAdd) {
  hear_some();
  Estimate slips;
  slips.alert = Alert::slip;
  slips.grip_increase_n = 1.5;
  EXPECT_EQ(hear(can::encode_alert(kBase + 0x20, slips, true, 0)), SLIP_CAN_HEARD_ALERT);
  EXPECT_EQ(now().alert, 2);
  EXPECT_NEAR(now().grip_increase_n, 1.5, 1e-9);
  EXPECT_EQ(hear(can::encode_alert(kBase + 0x20, slips, true, 0)), 0) << "the same again";
  slips.grip_increase_n.reset();
  hear(can::encode_alert(kBase + 0x20, slips, true, 1));
  EXPECT_TRUE(std::isnan(now().grip_increase_n));
}

TEST_F(SlipCan, FramesOfOthersAndDamagedOnesAreNotHeard) {
  hear_some();
  can::Message other = estimate(0.1);
  other.id = kBase + 1;
  EXPECT_EQ(hear(other), 0);
  for (unsigned bit = 0; bit < 64; ++bit) {
    can::Message damaged = estimate(0.1);
    damaged.data[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    EXPECT_EQ(hear(damaged), 0) << bit;
  }
  const can::Message cut = estimate(0.1);
  EXPECT_EQ(slip_can_hear(&slip_, cut.id, cut.data.data(), 7, now_s_), 0);
  EXPECT_NEAR(now().gamma, 0.7, 1e-9);
}

// tests/data/can: `candump -L` of a wire between two controllers, and what slipd said of the same frames on
// its socket.
TEST_F(SlipCan, ARecordingOfABusSaysWhatTheSocketSaid) {
  const std::string folder = SLIPD_SOURCE_DIR "/tests/data/can/";
  std::map<unsigned, nlohmann::json> said;  // by the 12 bits of the sequence number that are on the bus
  std::ifstream socket(folder + "socket.jsonl");
  for (std::string line; std::getline(socket, line);) {
    const auto values = nlohmann::json::parse(line);
    said[values["seq"].get<unsigned>() % 4096] = values;
  }
  std::ifstream bus(folder + "wire.candump");
  int margins = 0, alerts = 0, compared = 0;
  for (std::string line; std::getline(bus, line);) {
    double time_s = 0;
    unsigned id = 0;
    unsigned long long bytes = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "(%lf) can0 %x#%llx", &time_s, &id, &bytes), 3) << line;
    std::array<std::uint8_t, 8> data{};
    for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<std::uint8_t>(bytes >> (56 - 8 * i));
    const int heard = slip_can_hear(&slip_, id, data.data(), 8, time_s);
    ASSERT_NE(heard, 0) << line;
    alerts += heard == SLIP_CAN_HEARD_ALERT ? 1 : 0;
    const auto found = said.find(data[5] | (data[6] & 0x0FU) << 8);
    const slip_can_reading now = slip_can_now(&slip_, time_s);
    if (heard != SLIP_CAN_HEARD_ESTIMATE || slip_.to_ignore > 0 || found == said.end()) continue;
    const auto& truth = found->second;
    const bool ok = truth["state"] == "ok";
    EXPECT_EQ(now.state == SLIP_CAN_OK, ok) << line << truth;
    EXPECT_EQ(now.alert, truth["alert"] == "slip" ? 2 : truth["alert"] == "warn" ? 1 : 0) << line << truth;
    if (ok) {
      EXPECT_NEAR(now.gamma, truth["gamma"].get<double>(), 0.5001e-4) << line;
    }
    margins += ok ? 1 : 0;
    ++compared;
  }
  EXPECT_GT(compared, 100);
  EXPECT_GT(margins, 20);
  EXPECT_GT(alerts, 20);
}

// Whatever comes on the bus, and whenever: the margin is that of the other receiver.
TEST_F(SlipCan, HasTheMarginOfTheOtherReceiver) {
  std::mt19937 random(20);  // NOLINT(cert-msc51-cpp): the same in every run
  const auto one_in = [&](unsigned n) { return random() % n == 0; };
  MarginReceiver other(kBase, 0, kPeriod);
  Time now{std::chrono::seconds(1000)};
  unsigned heartbeats = 0;
  int margins = 0;
  for (int i = 0; i < 20000; ++i) {
    // Never three periods exactly, which doubles round.
    const std::chrono::microseconds step = one_in(50) ? 35ms : 9700us;
    now += step;
    now_s_ = std::chrono::duration<double>(now.time_since_epoch()).count();
    const auto state = one_in(20) ? static_cast<State>(random() % 8) : State::ok;
    can::Message message = estimate(static_cast<double>(random() % 1001) / 1000, state);
    if (one_in(10)) --counter_;  // the next one repeats
    if (one_in(100)) message = can::encode_heartbeat(kBase + 0x3F, {1, 5, one_in(2)}, heartbeats++);
    if (one_in(10)) message.data[random() % 8] ^= static_cast<std::uint8_t>(1U << random() % 8);
    if (!one_in(10)) {
      can_frame frame{};
      frame.can_id = message.id;
      frame.len = 8;
      std::copy(message.data.begin(), message.data.end(), frame.data);
      other.receive(frame, now);
      hear(message);
    }
    const auto expected = other.margin(now);
    ASSERT_EQ(!std::isnan(this->now().gamma), expected.has_value()) << i;
    if (!expected) continue;
    ASSERT_NEAR(this->now().gamma, *expected, 1e-9) << i;
    ++margins;
  }
  EXPECT_GT(margins, 1000) << "so that the comparison says something";
}

}  // namespace
}  // namespace slipd::testing
