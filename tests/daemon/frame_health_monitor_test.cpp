// Which log lines the frame health monitor writes about lost, corrupt and late frames, and how it limits
// them.
#include "daemon/telemetry/frame_health_monitor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slipd {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using namespace std::chrono_literals;

class FrameHealthMonitorTest : public ::testing::Test {
 protected:
  std::vector<std::string> after(std::chrono::seconds time, const HealthTotals& totals) {
    std::vector<std::string> lines;
    for (const HealthNotice& notice :
         health_monitor_.check(0, "left", "XELA on can0", totals, begin_ + time)) {
      EXPECT_NE(notice.cause, Cause::none) << "nobody is named in: " << notice.text;
      lines.push_back(notice.text);
    }
    return lines;
  }
  FrameHealthMonitor health_monitor_;
  const FrameHealthMonitor::Clock::time_point begin_ = FrameHealthMonitor::Clock::now();
};

TEST_F(FrameHealthMonitorTest, ReportsNothingWithoutAFault) {
  EXPECT_THAT(after(1s, {.received = 1000}), IsEmpty());
}

TEST_F(FrameHealthMonitorTest, TheDeviceIsNamedForWhatItDid) {
  EXPECT_THAT(after(1s, {.received = 1000, .corrupt = 1}),
              ElementsAre(HasSubstr("left (XELA on can0): 1 damaged packet thrown away")));
  EXPECT_THAT(after(2s, {.received = 2000, .corrupt = 1, .lost = 7}),
              ElementsAre(HasSubstr("7 frames never came whole (by the device's count, if it has one")));
}

TEST_F(FrameHealthMonitorTest, ADriverThatHangsIsReportedOnceEachTimeAndNotAtTheFirstLook) {
  const HealthTotals hangs{.driver_hangs = "its driver does not return"};
  EXPECT_THAT(after(1s, hangs), IsEmpty());
  EXPECT_THAT(after(2s, hangs), ElementsAre("left (XELA on can0): its driver does not return"));
  EXPECT_THAT(after(3s, hangs), IsEmpty());
  EXPECT_THAT(after(4s, {}), IsEmpty());
  EXPECT_THAT(after(5s, hangs), IsEmpty());
  EXPECT_THAT(after(6s, hangs), ElementsAre(HasSubstr("does not return")));
}

TEST_F(FrameHealthMonitorTest, ASensorThatMeasuresLessOftenThanItsFramesComeIsReported) {
  const auto second = [&](int s) {
    return after(std::chrono::seconds(s), {.received = static_cast<std::uint64_t>(41 * s),
                                           .repeated = static_cast<std::uint64_t>(31 * s)});
  };
  EXPECT_THAT(second(1), IsEmpty());
  EXPECT_THAT(second(2), IsEmpty());
  EXPECT_THAT(second(3), ElementsAre(HasSubstr("93 frames repeated the one before")));
  EXPECT_THAT(second(4), IsEmpty()) << "once a minute";
}

TEST_F(FrameHealthMonitorTest, FewRepeatedFramesAreNotReportedNorIsASensorThatStandsStill) {
  for (int s = 1; s <= 5; ++s) {
    const auto received = static_cast<std::uint64_t>(100 * s), repeated = static_cast<std::uint64_t>(10 * s);
    EXPECT_THAT(after(std::chrono::seconds(s), {.received = received, .repeated = repeated}), IsEmpty());
  }
  for (int s = 6; s <= 10; ++s) {
    const auto received = static_cast<std::uint64_t>(100 * s),
               repeated = static_cast<std::uint64_t>(100 * s - 450);
    EXPECT_THAT(after(std::chrono::seconds(s), {.received = received, .repeated = repeated}), IsEmpty());
  }
}

TEST_F(FrameHealthMonitorTest, ASimulationThatIsLateIsTheMachinesFault) {
  EXPECT_THAT(after(1s, {.received = 1000, .lost = 7, .simulated = true}),
              ElementsAre(HasSubstr("7 frames were not simulated in time: this machine")));
}

TEST_F(FrameHealthMonitorTest, ReportsOnceAMinuteWithTheTotalSinceTheLastReport) {
  EXPECT_EQ(after(1s, {.received = 1000, .corrupt = 5}).size(), 1U);
  for (int s = 2; s <= 60; ++s) {
    EXPECT_THAT(
        after(std::chrono::seconds(s), {.received = 1000, .corrupt = static_cast<std::uint64_t>(5 * s)}),
        IsEmpty());
  }
  EXPECT_THAT(after(61s, {.received = 1000, .corrupt = 305}), ElementsAre(HasSubstr("300 damaged packets")));
}

TEST_F(FrameHealthMonitorTest, AFewSkippedFramesAreNotReportedAndManyAreTheMachinesFault) {
  EXPECT_THAT(after(1s, {.received = 1000, .skipped = 10}), IsEmpty());
  EXPECT_THAT(after(2s, {.received = 2000, .skipped = 1000}), IsEmpty()) << "an estimator was being made";
  EXPECT_THAT(after(3s, {.received = 3000, .skipped = 1010}), IsEmpty());
  EXPECT_THAT(after(4s, {.received = 4000, .skipped = 1500}), IsEmpty());
  EXPECT_THAT(after(5s, {.received = 5000, .skipped = 2000}), IsEmpty());
  EXPECT_THAT(after(6s, {.received = 6000, .skipped = 2500}),
              ElementsAre(HasSubstr("this machine is too slow")));
}

}  // namespace
}  // namespace slipd
