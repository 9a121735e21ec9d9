#include "bridges/grip_ros2/goals.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bridges/grip_ros2/order_lines.hpp"

namespace slipd::grip_ros2 {
namespace {

constexpr std::int64_t kMs = 1'000'000;

// A driver in radians: 0 is open, 0.8 closed, and 2 of effort are 1 N.
GoalSettings settings() {
  return {.open = 0, .closed = 0.8, .effort_per_n = 2, .open_effort = 30, .goals_per_s = 10, .accept_s = 0.5};
}

Order grip(double force_n) {
  return {Move::grip, force_n};
}

GoalId id(std::uint8_t number) {
  GoalId goal;
  goal.uuid[0] = number;
  return goal;
}

GoalStatus listed(std::uint8_t number, std::int8_t status = 2) {
  return {.goal_id = id(number), .stamp = {}, .status = status};
}

// The goal for an order that stays.
std::optional<Goal> settled(Goals& goals, const Order& order, std::int64_t now_ns) {
  const std::optional<Goal> at_once = goals.due(order, now_ns);
  return at_once ? at_once : goals.due(order, now_ns);
}

TEST(Goals, GripTowardsClosedWithTheForceInTheDriversUnit) {
  Goals goals(settings());
  const auto goal = settled(goals, grip(3), 0);
  ASSERT_TRUE(goal);
  EXPECT_EQ(goal->position, 0.8);
  EXPECT_EQ(goal->effort, 6);
}

TEST(Goals, DoNothingWhileTheOrderIsToStay) {
  Goals goals(settings());
  EXPECT_FALSE(goals.due({Move::stay}, 0));
}

TEST(Goals, AreNotSentAgainForTheSameOrder) {
  Goals goals(settings());
  EXPECT_TRUE(settled(goals, grip(3), 0));
  EXPECT_FALSE(settled(goals, grip(3), 10'000 * kMs));
}

TEST(Goals, ThatDdsRefusedAreDueAgainAndItIsTold) {
  Goals goals(settings());
  ASSERT_TRUE(settled(goals, grip(3), 0));
  goals.note_refused();
  EXPECT_NE(goals.trouble(kMs).find("no goal can be sent"), std::string::npos);
  ASSERT_TRUE(goals.due(grip(3), kMs));
  goals.note_sent(id(1), kMs);
  EXPECT_EQ(goals.trouble(2 * kMs), "");
  EXPECT_FALSE(goals.due(grip(3), 2 * kMs));
}

TEST(Goals, WaitForAForceThatRisesInAFewOrders) {
  Goals goals(settings());
  for (const double force : {0.01, 1.0, 2.0}) EXPECT_FALSE(goals.due(grip(force), 0));
  const auto goal = goals.due(grip(2), 1 * kMs);
  ASSERT_TRUE(goal);
  EXPECT_EQ(goal->effort, 4);
}

TEST(Goals, OfAHoldThatWasQuietComeAsSoonAsTheForceHasRisen) {
  Goals goals(settings());
  ASSERT_TRUE(settled(goals, grip(3), 0));
  for (int ms = 1; ms < 5000; ++ms) ASSERT_FALSE(goals.due(grip(3), ms * kMs));
  EXPECT_FALSE(goals.due(grip(4), 5000 * kMs));
  EXPECT_TRUE(goals.due(grip(4), 5001 * kMs));
}

TEST(Goals, FollowAForceAtTheirRateAndWithItsNewestValue) {
  Goals goals(settings());
  ASSERT_TRUE(settled(goals, grip(3), 0));
  int sent = 0;
  double effort = 0;
  for (int ms = 1; ms <= 1000; ++ms) {
    if (const auto goal = goals.due(grip(3 + ms * 1e-3), ms * kMs)) {
      ++sent;
      effort = goal->effort;
    }
  }
  EXPECT_GE(sent, 9);
  EXPECT_LE(sent, 10);
  EXPECT_NEAR(effort, 8, 0.25) << "as it is, at most one goal late";
}

TEST(Goals, OpenAtOnce) {
  Goals goals(settings());
  ASSERT_TRUE(settled(goals, grip(3), 0));
  const auto goal = goals.due({Move::open}, 1 * kMs);
  ASSERT_TRUE(goal);
  EXPECT_EQ(goal->position, 0);
  EXPECT_EQ(goal->effort, 30);
  EXPECT_TRUE(settled(goals, grip(3), 2 * kMs)) << "and grip again at once";
}

TEST(Goals, AreInTroubleWhenTheServerDoesNotListOneInTime) {
  Goals goals(settings());
  goals.note_sent(id(1), 0);
  EXPECT_EQ(goals.trouble(500 * kMs), "");
  EXPECT_NE(goals.trouble(501 * kMs), "");
}

TEST(Goals, ThatTheServerListedAreNotSentAgainForTheSameOrder) {
  Goals goals(settings());
  ASSERT_TRUE(settled(goals, grip(3), 0));
  goals.note_sent(id(1), 0);
  goals.note_listed(listed(1));
  EXPECT_FALSE(goals.due(grip(3), 10'000 * kMs));
}

// As slipd-grip orders while the gripper counts as gone: the same all the time.
TEST(Goals, ThatTheServerDoesNotListInTimeAreSentAgainUntilItListsOne) {
  Goals goals(settings());
  std::uint8_t sent = 0;
  for (int ms = 0; ms <= 10'000; ++ms) {
    if (const auto goal = goals.due(grip(3), ms * kMs)) {
      EXPECT_EQ(goal->effort, 6);
      goals.note_sent(id(++sent), ms * kMs);
    }
    if (ms > 501) {
      ASSERT_NE(goals.trouble(ms * kMs), "") << "none is listed yet, at " << ms << " ms";
    }
  }
  EXPECT_GE(sent, 19);
  EXPECT_LE(sent, 20) << "at most one each time that one may take";
  goals.note_listed(listed(sent));
  EXPECT_EQ(goals.trouble(20'000 * kMs), "");
  EXPECT_FALSE(goals.due(grip(3), 20'000 * kMs));
}

TEST(Goals, ToOpenAreSentAgainToo) {
  Goals goals(settings());
  ASSERT_TRUE(goals.due({Move::open}, 0));
  goals.note_sent(id(1), 0);
  EXPECT_FALSE(goals.due({Move::open}, 500 * kMs));
  EXPECT_TRUE(goals.due({Move::open}, 501 * kMs));
}

TEST(Goals, AreSentAgainAtTheirRateAtMostHoweverSoonTheServerShouldListThem) {
  GoalSettings hasty = settings();
  hasty.accept_s = 0.01;
  Goals goals(hasty);
  ASSERT_TRUE(settled(goals, grip(3), 0));
  goals.note_sent(id(1), 0);
  EXPECT_FALSE(goals.due(grip(3), 99 * kMs));
  EXPECT_TRUE(goals.due(grip(3), 100 * kMs));
}

TEST(Goals, AreInTroubleHoweverManyTheServerDoesNotList) {
  Goals goals(settings());
  for (int i = 0; i < 1000; ++i) goals.note_sent(id(static_cast<std::uint8_t>(i)), i * 10 * kMs);
  EXPECT_NE(goals.trouble(9991 * kMs), "") << "the newest is young, and the first was never listed";
}

TEST(Goals, AreInTroubleAlthoughNewOnesAreSentAllTheTime) {
  Goals goals(settings());
  for (std::uint8_t i = 0; i < 20; ++i) goals.note_sent(id(i), i * 100 * kMs);
  EXPECT_NE(goals.trouble(1900 * kMs), "");
}

TEST(Goals, AreFineOnceALaterOneIsListed) {
  Goals goals(settings());
  goals.note_sent(id(1), 0);
  goals.note_sent(id(2), 100 * kMs);
  goals.note_listed(listed(2));
  EXPECT_EQ(goals.trouble(10'000 * kMs), "") << "the first one was given up before it was listed";
}

TEST(Goals, AreNotHelpedByGoalsOfOthers) {
  Goals goals(settings());
  goals.note_sent(id(1), 0);
  goals.note_listed(listed(9));
  EXPECT_NE(goals.trouble(1000 * kMs), "");
}

TEST(Goals, TellThatTheNewestWasGivenUp) {
  Goals goals(settings());
  goals.note_sent(id(1), 0);
  goals.note_sent(id(2), 0);
  goals.note_listed(listed(1, GoalStatus::kAborted));
  EXPECT_FALSE(goals.aborted());
  goals.note_listed(listed(2, GoalStatus::kAborted));
  EXPECT_TRUE(goals.aborted());
  goals.note_sent(id(3), 0);
  EXPECT_FALSE(goals.aborted());
}

TEST(Goals, AreSentAnewToAnotherServer) {
  Goals goals(settings());
  ASSERT_TRUE(settled(goals, grip(3), 0));
  goals.note_sent(id(1), 0);
  goals.forget();
  EXPECT_EQ(goals.trouble(10'000 * kMs), "");
  EXPECT_TRUE(settled(goals, grip(3), 1 * kMs));
}

TEST(OrderLines, AreThoseOfSlipdGrip) {
  EXPECT_EQ(order_of(R"({"force_n":3.2,"order":"grip","sequence":4711,"speed_mm_s":50.0})"), grip(3.2));
  EXPECT_EQ(order_of(R"({"order":"open","sequence":1})"), Order{Move::open});
  EXPECT_EQ(order_of(R"({"order":"stay"})"), Order{Move::stay});
}

TEST(OrderLines, ThatAreNoOrdersMoveNothing) {
  for (const char* line :
       {"", "open", "[]", "{}", R"({"order":"grip"})", R"({"order":"grip","force_n":-1})",
        R"({"order":"grip","force_n":"3"})", R"({"order":"grip","force_n":null})", R"({"order":7})"})
    EXPECT_FALSE(order_of(line)) << line;
}

TEST(OrderLines, LeaveOutWhatIsUnknown) {
  EXPECT_EQ(answer_of(41.5, std::nullopt), R"({"width_mm":41.5})");
  EXPECT_EQ(answer_of(std::nan(""), std::nan("")), "{}");
}

}  // namespace
}  // namespace slipd::grip_ros2
