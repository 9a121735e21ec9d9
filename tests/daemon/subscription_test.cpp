// Which estimates a subscriber gets: its rate, its kinds of events, and the count of losses.
#include "daemon/rpc/clients/subscription.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "daemon/rpc/protocol/rpc.hpp"

namespace slipd {
namespace {

using nlohmann::json;

class SubscriptionTest : public ::testing::Test {
 protected:
  SubscriptionTest() {
    board_.sensors.push_back(std::make_unique<SensorStatus>("left", "trial"));
    board_.sensors.push_back(std::make_unique<SensorStatus>("right", "trial"));
  }
  static Event at_ms(double ms, State state = State::ok) {
    Event event;
    event.estimate.state = state;
    event.estimate.published_ns = static_cast<std::int64_t>(ms * 1e6) + 1'000'000'000;
    return event;
  }
  int accepted(Subscription& subscription, double every_ms, double for_ms) {
    int count = 0;
    for (double ms = 0; ms < for_ms; ms += every_ms) {
      count += subscription.accepts(at_ms(ms), EventKind::estimate, lost_) ? 1 : 0;
    }
    return count;
  }
  Board board_;
  std::uint64_t lost_ = 0;
};

TEST_F(SubscriptionTest, EstimatesAreThinnedToTheRateAskedFor) {
  for (const double hz : {1.0, 30.0, 99.0, 500.0}) {
    Subscription subscription(1, {{"max_rate_hz", hz}}, board_);
    const int count = accepted(subscription, 1, 10000);
    EXPECT_LE(count, 10 * hz + 1) << hz;
    EXPECT_GE(count, 10 * hz * 0.9) << hz;
  }
  Subscription all(2, json::object(), board_);
  EXPECT_EQ(accepted(all, 1, 1000), 1000);
}

TEST_F(SubscriptionTest, AChangeOfStateIsSentAtAnyRate) {
  Subscription slow(1, {{"max_rate_hz", 1}}, board_);
  EXPECT_TRUE(slow.accepts(at_ms(0), EventKind::estimate, lost_));
  EXPECT_FALSE(slow.accepts(at_ms(1), EventKind::estimate, lost_));
  EXPECT_TRUE(slow.accepts(at_ms(2, State::stale), EventKind::estimate, lost_));
}

TEST_F(SubscriptionTest, LossesAreSummedUntilTheNextNotification) {
  Subscription slow(1, {{"max_rate_hz", 1}}, board_);
  slow.accepts(at_ms(0), EventKind::estimate, lost_);
  Event event = at_ms(10);
  event.lost_before = 3;
  EXPECT_FALSE(slow.accepts(event, EventKind::estimate, lost_));
  event = at_ms(2000);
  event.lost_before = 4;
  EXPECT_TRUE(slow.accepts(event, EventKind::estimate, lost_));
  EXPECT_EQ(lost_, 7U);
}

TEST_F(SubscriptionTest, OnlyTheRequestedSensorsAndEventsAreSent) {
  Subscription subscription(1, {{"sensors", {"right"}}, {"events", {"alert"}}}, board_);
  Event event = at_ms(0);
  EXPECT_FALSE(subscription.accepts(event, EventKind::alert, lost_));
  event.sensor = 1;
  EXPECT_TRUE(subscription.accepts(event, EventKind::alert, lost_));
  EXPECT_FALSE(subscription.accepts(event, EventKind::estimate, lost_));
  EXPECT_TRUE(subscription.wants("right", EventKind::alert));
  EXPECT_FALSE(subscription.wants("left", EventKind::alert));
  EXPECT_FALSE(subscription.wants("right", EventKind::state));
  EXPECT_THROW(Subscription(2, {{"sensors", {"middle"}}}, board_), rpc::Error);
  EXPECT_THROW(Subscription(2, {{"sensors", "left"}}, board_), rpc::Error);
  EXPECT_THROW(Subscription(2, {{"events", "alert"}}, board_), rpc::Error);
}

}  // namespace
}  // namespace slipd
