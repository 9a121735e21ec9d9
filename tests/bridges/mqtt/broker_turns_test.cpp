#include "bridges/mqtt/broker_turns.hpp"

#include <gtest/gtest.h>

namespace slipd::mqtt {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(BrokerTurns, TriesAllBrokersBeforeItPauses) {
  BrokerTurns turns(3);
  EXPECT_EQ(turns.lost({}, 0), milliseconds(0));
  EXPECT_EQ(turns.current(), 1U);
  EXPECT_EQ(turns.lost({}, 0), milliseconds(0));
  EXPECT_EQ(turns.current(), 2U);
  EXPECT_EQ(turns.lost({}, 0), milliseconds(500));
  EXPECT_EQ(turns.current(), 0U);
}

TEST(BrokerTurns, BeginAtTheBrokerThatTheyAreGiven) {
  BrokerTurns turns(3, {}, 2);
  EXPECT_EQ(turns.current(), 2U);
  EXPECT_EQ(turns.lost({}, 0), milliseconds(0));
  EXPECT_EQ(turns.current(), 0U);
}

TEST(BrokerTurns, PausesGrowToALimit) {
  BrokerTurns turns(1);
  milliseconds last(0);
  for (int i = 0; i < 20; ++i) {
    const milliseconds pause = turns.lost({}, 0);
    EXPECT_GE(pause, last);
    last = pause;
  }
  EXPECT_EQ(last, seconds(30));
}

TEST(BrokerTurns, OnlyASteadyConnectionBeginsPausesAnew) {
  BrokerTurns turns(1);
  for (int i = 0; i < 4; ++i) turns.lost(milliseconds(100), 0);
  EXPECT_EQ(turns.lost(milliseconds(100), 0), seconds(8));
  EXPECT_EQ(turns.lost(seconds(60), 0), milliseconds(500));
}

TEST(BrokerTurns, ALossOfASteadyBrokerTriesTheNextAtOnce) {
  BrokerTurns turns(2);
  turns.lost({}, 0);
  EXPECT_EQ(turns.lost(seconds(60), 0), milliseconds(0));
}

TEST(BrokerTurns, ChanceShortensAPauseByAHalfAtMost) {
  BrokerTurns one(1), other(1);
  EXPECT_EQ(one.lost({}, 1), milliseconds(250));
  EXPECT_EQ(other.lost({}, 0.5), milliseconds(375));
}

}  // namespace
}  // namespace slipd::mqtt
