// Every transition of the load history's state, and the counts of frames on which two of them depend.
#include "core/friction/history_state.hpp"

#include <gtest/gtest.h>

#include <array>

#include "core/health/usual.hpp"

namespace slipd {
namespace {

using Known = HistoryState;
using Event = HistoryEvent;
constexpr std::array kStates{Known::monotonic, Known::general, Known::assumed_monotonic, Known::unknown};

TEST(HistoryState, EachEventLeadsWhereTheTableSays) {
  struct Row {
    Event event;
    std::array<HistoryState, 4> to;  // the next state from each of kStates
  };
  const Row rows[] = {
      {Event::contact_lost, {Known::monotonic, Known::monotonic, Known::monotonic, Known::monotonic}},
      {Event::loaded_at_onset,
       {Known::assumed_monotonic, Known::assumed_monotonic, Known::assumed_monotonic,
        Known::assumed_monotonic}},
      {Event::shear_turned,
       {Known::assumed_monotonic, Known::assumed_monotonic, Known::assumed_monotonic,
        Known::assumed_monotonic}},
      {Event::outlier_run,
       {Known::assumed_monotonic, Known::assumed_monotonic, Known::assumed_monotonic,
        Known::assumed_monotonic}},
      {Event::unseen,
       {Known::assumed_monotonic, Known::assumed_monotonic, Known::assumed_monotonic,
        Known::assumed_monotonic}},
      {Event::frame_monotonic,
       {Known::monotonic, Known::monotonic, Known::assumed_monotonic, Known::assumed_monotonic}},
      {Event::frame_not_monotonic, {Known::general, Known::general, Known::unknown, Known::unknown}},
      {Event::assumption_confirmed, {Known::monotonic, Known::general, Known::monotonic, Known::unknown}},
  };
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < kStates.size(); ++i) {
      EXPECT_EQ(next_state(kStates[i], row.event), row.to[i])
          << "state " << i << ", event " << static_cast<int>(row.event);
    }
  }
}

TEST(HistoryState, OnlyAConfirmationOrANewGraspMakesALostHistoryKnown) {
  for (const auto from : {Known::assumed_monotonic, Known::unknown}) {
    for (const auto event : {Event::loaded_at_onset, Event::shear_turned, Event::outlier_run, Event::unseen,
                             Event::frame_monotonic, Event::frame_not_monotonic})
      EXPECT_FALSE(is_known(next_state(from, event)));
  }
  EXPECT_FALSE(is_known(next_state(Known::unknown, Event::assumption_confirmed)));
}

TEST(HistoryMonitor, BeginsWithAHistoryThatIsKnown) {
  EXPECT_EQ(HistoryMonitor().state(), Known::monotonic);
}

TEST(HistoryMonitor, ARunOfOutliersIsCompleteAtSureFrames) {
  HistoryMonitor monitor({.confirming_frames = 2});
  for (std::uint32_t i = 1; i < kSureFrames; ++i) EXPECT_FALSE(monitor.outlier());
  EXPECT_TRUE(monitor.outlier());
  EXPECT_FALSE(monitor.outlier()) << "the next run begins anew";
}

TEST(HistoryMonitor, AFrameThatIsExplainedEndsARunOfOutliers) {
  HistoryMonitor monitor({.confirming_frames = 2});
  for (int i = 0; i < 10; ++i) {
    EXPECT_FALSE(monitor.outlier());
    monitor.explained(i % 2 == 0);
  }
}

TEST(HistoryMonitor, ConfirmingFramesMakeAnAssumedHistoryKnown) {
  HistoryMonitor monitor({.confirming_frames = 3});
  monitor.lose(Event::loaded_at_onset);
  EXPECT_EQ(monitor.state(), Known::assumed_monotonic);
  monitor.explained(true);
  monitor.explained(true);
  EXPECT_EQ(monitor.state(), Known::assumed_monotonic);
  monitor.explained(true);
  EXPECT_EQ(monitor.state(), Known::monotonic);
}

TEST(HistoryMonitor, FramesThatWereNotReadAsMonotonicConfirmNothing) {
  HistoryMonitor monitor({.confirming_frames = 1});
  monitor.lose(Event::shear_turned);
  for (int i = 0; i < 10; ++i) monitor.explained(false);
  EXPECT_EQ(monitor.state(), Known::assumed_monotonic);
}

TEST(HistoryMonitor, AHistoryThatIsLostAgainIsConfirmedAllOver) {
  HistoryMonitor monitor({.confirming_frames = 2});
  monitor.lose(Event::outlier_run);
  monitor.explained(true);
  monitor.lose(Event::outlier_run);
  monitor.explained(true);
  EXPECT_EQ(monitor.state(), Known::assumed_monotonic);
  monitor.explained(true);
  EXPECT_EQ(monitor.state(), Known::monotonic);
}

TEST(HistoryMonitor, UnloadingAfterALostHistoryLeavesItUnknownUntilTheLoadIsMonotonicAgain) {
  HistoryMonitor monitor;
  monitor.lose(Event::loaded_at_onset);
  monitor.classify(false);
  EXPECT_EQ(monitor.state(), Known::unknown);
  monitor.classify(true);
  EXPECT_EQ(monitor.state(), Known::assumed_monotonic);
}

TEST(HistoryMonitor, ALostContactForgetsBothCounts) {
  HistoryMonitor monitor({.confirming_frames = 2});
  monitor.outlier();
  monitor.lose(Event::loaded_at_onset);
  monitor.explained(true);
  for (std::uint32_t i = 1; i < kSureFrames; ++i) monitor.outlier();
  monitor.contact_lost();
  EXPECT_EQ(monitor.state(), Known::monotonic);
  EXPECT_FALSE(monitor.outlier());
  monitor.lose(Event::loaded_at_onset);
  monitor.explained(true);
  EXPECT_EQ(monitor.state(), Known::assumed_monotonic);
}

}  // namespace
}  // namespace slipd
