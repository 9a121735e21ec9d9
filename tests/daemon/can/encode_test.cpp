// Encoded messages agree with the DBC, bit for bit.
#include "daemon/can/encode.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "daemon/can/signals.hpp"
#include "embedded/slipd_dbc.hpp"
#include "tests/support/dbc.hpp"

namespace slipd::can {
namespace {

constexpr std::uint32_t kBase = 0x5A0;

const std::map<std::uint32_t, testing::DbcMessage>& shipped() {
  static const auto messages = testing::read_dbc(std::string(slipd_dbc));
  return messages;
}

template <std::size_t N>
void expect_same(const testing::DbcMessage& message, const std::array<Signal, N>& signals) {
  EXPECT_EQ(message.signals.size(), N) << message.name;
  EXPECT_EQ(message.length, 8U);
  EXPECT_FALSE(message.comment.empty()) << message.name;
  std::uint64_t used = 0;
  for (const Signal& signal : signals) {
    SCOPED_TRACE(message.name + " " + signal.name);
    const testing::DbcSignal& defined = message.signals.at(signal.name);
    EXPECT_EQ(defined.start, signal.start);
    EXPECT_EQ(defined.length, signal.length);
    EXPECT_TRUE(defined.little_endian);
    EXPECT_FALSE(defined.is_signed);
    EXPECT_DOUBLE_EQ(defined.scale, signal.scale);
    EXPECT_DOUBLE_EQ(defined.offset, signal.offset);
    EXPECT_FALSE(defined.comment.empty());
    const std::uint64_t bits = ((std::uint64_t{1} << signal.length) - 1) << signal.start;
    EXPECT_EQ(used & bits, 0U) << "lies over another signal";
    used |= bits;
  }
}

TEST(CanEncode, EverySignalLiesWhereTheDbcSays) {
  ASSERT_EQ(shipped().size(), 4U);
  expect_same(shipped().at(kBase), estimate::kAll);
  expect_same(shipped().at(kBase + kAlertOffset), alert::kAll);
  expect_same(shipped().at(kBase + kSlidingOffset), sliding::kAll);
  expect_same(shipped().at(kBase + kHeartbeatOffset), heartbeat::kAll);
}

TEST(CanEncode, TheValueTablesAreTheWordsOfTheSocket) {
  const auto& signals = shipped().at(kBase).signals;
  for (int state = 0; state <= static_cast<int>(State::fault); ++state)
    EXPECT_EQ(signals.at("State").values.at(static_cast<std::uint64_t>(state)),
              to_string(static_cast<State>(state)));
  for (int level = 0; level <= static_cast<int>(Alert::unknown); ++level)
    for (const auto id : {kBase, kBase + kAlertOffset, kBase + kSlidingOffset})
      EXPECT_EQ(shipped().at(id).signals.at("Alert").values.at(static_cast<std::uint64_t>(level)),
                to_string(static_cast<Alert>(level)));
  const auto& sliding = shipped().at(kBase + kSlidingOffset).signals.at("Sliding").values;
  for (int kind = 0; kind <= static_cast<int>(Sliding::rotation); ++kind)
    EXPECT_EQ(sliding.at(static_cast<std::uint64_t>(kind)), to_string(static_cast<Sliding>(kind)));
  EXPECT_TRUE(sliding.contains(sliding::kSlidingNotAvailable));
  const auto& cause = shipped().at(kBase + kAlertOffset).signals.at("Cause").values;
  EXPECT_EQ(cause.at(0), to_string(AlertCause::margin));
  EXPECT_EQ(cause.at(1), to_string(AlertCause::sliding));
}

TEST(CanEncode, TorqueIsSentWithItsSignAndUnknownIsNotZero) {
  const testing::DbcSignal& torque = shipped().at(kBase + kSlidingOffset).signals.at("Torque");
  Estimate e;
  EXPECT_EQ(torque.raw(encode_sliding(kBase + kSlidingOffset, e, false, 0).data), kNotAvailable);
  for (const double torque_nm : {0.0, 0.0125, -0.3, 3.2}) {
    e.torque_nm = torque_nm;
    EXPECT_NEAR(torque.physical(encode_sliding(kBase + kSlidingOffset, e, false, 0).data), 1e3 * torque_nm,
                0.051);
  }
  for (const double torque_nm : {50.0, -50.0}) {
    e.torque_nm = torque_nm;
    EXPECT_NEAR(torque.physical(encode_sliding(kBase + kSlidingOffset, e, false, 0).data),
                std::copysign(3276.7, torque_nm), 0.051);
  }
}

TEST(CanEncode, SlidingIsSentAsItIsAndUnknownIsNotNone) {
  const auto& signals = shipped().at(kBase + kSlidingOffset).signals;
  const auto raw = [&](const Message& message, const char* name) {
    return signals.at(name).raw(message.data);
  };
  Estimate e;
  e.sequence = 5000;
  e.alert = Alert::slip;
  e.alert_cause = AlertCause::sliding;
  for (const Sliding kind : {Sliding::none, Sliding::disturbed, Sliding::translation, Sliding::rotation}) {
    e.sliding = kind;
    e.sliding_for_s = 1.25;
    const Message message = encode_sliding(kBase + kSlidingOffset, e, true, 3);
    EXPECT_EQ(raw(message, "Sliding"), static_cast<std::uint64_t>(kind));
    EXPECT_EQ(raw(message, "SlidingFor"), 1250U);
    EXPECT_EQ(raw(message, "Alert"), 2U);
    EXPECT_EQ(raw(message, "Simulated"), 1U);
    EXPECT_EQ(raw(message, "Sequence"), 5000U % 4096);
    EXPECT_EQ(raw(message, "Counter"), 3U);
    EXPECT_EQ(raw(message, "Crc8"), crc8(message.id, std::span(message.data).first<7>()));
  }
  e.sliding_for_s = 1e9;
  EXPECT_EQ(raw(encode_sliding(kBase + kSlidingOffset, e, true, 3), "SlidingFor"), 0xFFFEU);
  e.sliding.reset();
  const Message unknown = encode_sliding(kBase + kSlidingOffset, e, true, 3);
  EXPECT_EQ(raw(unknown, "Sliding"), sliding::kSlidingNotAvailable);
  EXPECT_EQ(raw(unknown, "SlidingFor"), kNotAvailable);
  const auto cause = [&] {
    return shipped()
        .at(kBase + kAlertOffset)
        .signals.at("Cause")
        .raw(encode_alert(kBase + kAlertOffset, e, true, 0).data);
  };
  EXPECT_EQ(cause(), 1U);
  e.alert_cause = AlertCause::margin;
  EXPECT_EQ(cause(), 0U);
}

TEST(CanEncode, TheChecksumIsSaeJ1850OverIdAndData) {
  const std::string_view check = "123456789";
  std::array<std::uint8_t, 9> bytes{};
  std::copy(check.begin(), check.end(), bytes.begin());
  EXPECT_EQ(crc8(bytes), 0x4B);
  EXPECT_EQ(crc8(0x34333231, std::span(bytes).subspan(4)), 0x4B) << "the id goes first, little-endian";
}

void expect_value(const testing::DbcSignal& signal, const Message& message, double value) {
  if (std::isnan(value)) {
    EXPECT_EQ(signal.raw(message.data), kNotAvailable);
  } else {
    EXPECT_NEAR(signal.physical(message.data), value, signal.scale * 0.5001);
  }
}

TEST(CanEncode, WhatTheDbcDecodesIsTheEstimateWithinOneCount) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto maybe = [&](double largest) {
    return unit(random) < 0.2 ? std::nullopt : std::optional(largest * unit(random));
  };
  const auto& as_estimate = shipped().at(kBase).signals;
  const auto& as_alert = shipped().at(kBase + kAlertOffset).signals;
  for (int i = 0; i < 2000; ++i) {
    Estimate e;
    e.state = static_cast<State>(random() % 8);
    e.alert = static_cast<Alert>(random() % 4);
    e.sequence = random();
    e.gamma = maybe(1);
    e.friction = maybe(6.5);
    e.grip_increase_n = maybe(655);
    e.time_to_slip_s = maybe(65);
    const bool simulated = random() % 2 == 0;
    const auto counter = static_cast<unsigned>(random() % 100);
    const double margin = e.state == State::ok ? e.gamma.value_or(kUnknown) : kUnknown;

    const Message estimate = encode_estimate(kBase, e, simulated, counter);
    const auto raw = [&](const char* name) { return as_estimate.at(name).raw(estimate.data); };
    expect_value(as_estimate.at("Gamma"), estimate, margin);
    expect_value(as_estimate.at("Friction"), estimate, e.friction.value_or(kUnknown));
    EXPECT_EQ(raw("State"), static_cast<std::uint64_t>(e.state));
    EXPECT_EQ(raw("Alert"), static_cast<std::uint64_t>(e.alert));
    EXPECT_EQ(raw("Simulated"), simulated ? 1U : 0U);
    EXPECT_EQ(raw("Sequence"), e.sequence % 4096);
    EXPECT_EQ(raw("Counter"), counter % 16);
    EXPECT_EQ(raw("Crc8"), crc8(estimate.id, std::span(estimate.data).first<7>()));

    const Message alert = encode_alert(kBase + kAlertOffset, e, simulated, counter);
    expect_value(as_alert.at("Gamma"), alert, margin);
    expect_value(as_alert.at("GripIncrease"), alert, e.grip_increase_n.value_or(kUnknown));
    expect_value(as_alert.at("TimeToSlip"), alert, e.time_to_slip_s.value_or(kUnknown) * 1e3);
    EXPECT_EQ(as_alert.at("Alert").raw(alert.data), static_cast<std::uint64_t>(e.alert));
    EXPECT_EQ(as_alert.at("Crc8").raw(alert.data), crc8(alert.id, std::span(alert.data).first<7>()));
  }
}

TEST(CanEncode, NoValueReachesTheMarkOfAnUnknownOneNorItsNeighbours) {
  Estimate e;
  e.state = State::ok;
  for (const double extreme : {-1.0, 1e30, std::numeric_limits<double>::infinity()}) {
    e.gamma = e.friction = e.grip_increase_n = e.time_to_slip_s = extreme;
    const bool low = extreme < 0;
    const auto& signals = shipped().at(kBase + kAlertOffset).signals;
    const Message alert = encode_alert(kBase + kAlertOffset, e, false, 0);
    EXPECT_EQ(signals.at("Gamma").raw(alert.data), low ? 0U : 10000U);
    EXPECT_EQ(signals.at("GripIncrease").raw(alert.data), low ? 0U : 0xFFFEU);
    EXPECT_EQ(signals.at("TimeToSlip").raw(alert.data), low ? 0U : 0xFFFEU);
    EXPECT_EQ(signals.at("Alert").raw(alert.data), 3U) << "unknown";
  }
  e.gamma = e.friction = kUnknown;
  const Message estimate = encode_estimate(kBase, e, false, 0);
  EXPECT_EQ(shipped().at(kBase).signals.at("Gamma").raw(estimate.data), kNotAvailable);
  EXPECT_EQ(shipped().at(kBase).signals.at("Friction").raw(estimate.data), kNotAvailable);
}

TEST(CanEncode, TheHeartbeatTellsUptimeAndStopping) {
  const auto& signals = shipped().at(kBase + kHeartbeatOffset).signals;
  const Message message = encode_heartbeat(kBase + kHeartbeatOffset, {3, 70000, true}, 17);
  EXPECT_EQ(signals.at("Protocol").raw(message.data), kProtocol);
  EXPECT_EQ(signals.at("Messages").raw(message.data), 3U);
  EXPECT_EQ(signals.at("Uptime").raw(message.data), 70000U);
  EXPECT_EQ(signals.at("Stopping").raw(message.data), 1U);
  EXPECT_EQ(signals.at("Counter").raw(message.data), 1U);
}

}  // namespace
}  // namespace slipd::can
