// The limit of the log: a line that repeats is printed a few times a minute, and counted.
#include "daemon/log/log_limit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <string>

namespace slipd {
namespace {

using namespace std::chrono_literals;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class Limit : public ::testing::Test {
 protected:
  static LogLine line(const char* kind, const char* sensor) {
    LogRing ring;
    ring.write(LogLevel::warning, {sensor, Cause::device}, "%s", kind);
    LogLine read;
    EXPECT_TRUE(ring.read(read));
    read.format = kind;
    return read;
  }
  int admitted(const char* kind, const char* sensor, int times, std::chrono::seconds at) {
    int count = 0;
    for (int i = 0; i < times; ++i) count += limit_.admits(line(kind, sensor), begin_ + at) ? 1 : 0;
    return count;
  }
  LogLimit limit_;
  const LogLimit::Clock::time_point begin_ = LogLimit::Clock::now();
};

constexpr const char* kStale = "no frame";
constexpr const char* kGone = "the device is gone";

TEST_F(Limit, AFewPassAndTheRestIsCountedUntilTheMinuteIsOver) {
  EXPECT_EQ(admitted(kStale, "left", 100, 0s), LogLimit::kPrintedPerWindow);
  EXPECT_THAT(limit_.take_expired(begin_ + 59s), IsEmpty());
  const auto held = limit_.take_expired(begin_ + 61s);
  ASSERT_THAT(held, SizeIs(1));
  EXPECT_EQ(held.front().count, 100U - LogLimit::kPrintedPerWindow);
  EXPECT_STREQ(held.front().last.text, kStale);
  EXPECT_STREQ(held.front().last.sensor, "left");
  EXPECT_EQ(held.front().last.cause, Cause::device);
  EXPECT_EQ(held.front().within, 1min);
  EXPECT_THAT(limit_.take_expired(begin_ + 62s), IsEmpty());
}

TEST_F(Limit, WhatGoesOnIsOnlyCountedInLongerAndLongerWindowsUntilItStops) {
  EXPECT_EQ(admitted(kStale, "left", 100, 0s), LogLimit::kPrintedPerWindow);
  EXPECT_THAT(limit_.take_expired(begin_ + 61s), SizeIs(1));
  EXPECT_EQ(admitted(kStale, "left", 100, 62s), 0);
  EXPECT_THAT(limit_.take_expired(begin_ + 122s), IsEmpty());
  const auto held = limit_.take_expired(begin_ + 182s);
  ASSERT_THAT(held, SizeIs(1));
  EXPECT_EQ(held.front().count, 100U);
  EXPECT_EQ(held.front().within, 2min);
  int summaries = 0;
  for (int minute = 4; minute < 24 * 60; ++minute) {
    EXPECT_EQ(admitted(kStale, "left", 100, minute * 60s), 0);
    summaries += static_cast<int>(limit_.take_expired(begin_ + minute * 60s).size());
  }
  EXPECT_LT(summaries, 30) << "in a day";
  EXPECT_THAT(limit_.take_expired(begin_ + 48h), SizeIs(1));
  EXPECT_THAT(limit_.take_expired(begin_ + 50h), IsEmpty());
  EXPECT_EQ(admitted(kStale, "left", 100, 51h), LogLimit::kPrintedPerWindow) << "after a window without any";
}

TEST_F(Limit, ManySensorsOfOneBusDoNotFillTheLog) {
  int printed = 0;
  for (int sensor = 0; sensor < 100; ++sensor)
    printed += admitted(kStale, ("board " + std::to_string(sensor)).c_str(), 1, 0s);
  EXPECT_EQ(printed, LogLimit::kPrintedOfAllSensors);
  EXPECT_EQ(admitted(kGone, "board 7", 1, 0s), 1) << "of another kind";
}

TEST_F(Limit, OneSensorsFlapsHideNeitherAnothersNorAnotherTrouble) {
  EXPECT_EQ(admitted(kStale, "left", 100, 0s), LogLimit::kPrintedPerWindow);
  EXPECT_EQ(admitted(kGone, "left", 3, 1s), 3);
  EXPECT_EQ(admitted(kStale, "right", 3, 1s), 3);
  EXPECT_THAT(limit_.take_expired(begin_ + 2min), SizeIs(1))
      << "a line that was not held back is not repeated";
}

TEST(LogLines, ThatAreTooLongAreCut) {
  LogRing ring;
  ring.write(LogLevel::info, {std::string(500, 's')}, "%s", std::string(500, 't').c_str());
  LogLine line;
  ASSERT_TRUE(ring.read(line));
  EXPECT_EQ(std::strlen(line.sensor), sizeof line.sensor - 1);
  EXPECT_EQ(std::strlen(line.text), sizeof line.text - 1);
}

TEST(Causes, AreNamedAsInTheJournal) {
  EXPECT_EQ(to_string(Cause::none), "");
  EXPECT_EQ(to_string(Cause::configuration), "configuration");
  EXPECT_EQ(to_string(Cause::slipd), "slipd");
}

}  // namespace
}  // namespace slipd
