// How many estimate threads there are, and which sensors each has.
#include "daemon/pipeline/estimate_threads.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

namespace slipd {
namespace {

using ::testing::ElementsAre;
using Parts = std::vector<std::vector<std::size_t>>;

TEST(EstimateThreads, ShareSensorsInEqualNumbers) {
  const Parts parts = share_out(128, {}, 2);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].size(), 64U);
  EXPECT_EQ(parts[1].size(), 64U);
}

TEST(EstimateThreads, KeepTheSensorsOfAGraspTogether) {
  EXPECT_THAT(share_out(5, {{0, 3}, {1, 4}}, 2), ElementsAre(ElementsAre(0, 2, 3), ElementsAre(1, 4)));
}

TEST(EstimateThreads, KeepGraspsWithACommonSensorTogether) {
  EXPECT_THAT(share_out(6, {{4, 5}, {0, 1}, {1, 5}}, 3),
              ElementsAre(ElementsAre(0, 1, 4, 5), ElementsAre(2), ElementsAre(3)));
}

TEST(EstimateThreads, AreNoMoreThanThereIsToShare) {
  EXPECT_THAT(share_out(3, {{0, 1, 2}}, 4), ElementsAre(ElementsAre(0, 1, 2)));
}

TEST(EstimateThreads, HaveEachSensorOnceAndEachGraspInOneThreadWhateverTheGrasps) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const std::size_t sensors = 1 + random() % 40, threads = 1 + random() % 6;
    Parts grasps(random() % 12);
    for (auto& grasp : grasps) {
      std::set<std::size_t> members;
      for (std::size_t i = 0; i <= random() % 4; ++i) members.insert(random() % sensors);
      grasp.assign(members.begin(), members.end());
    }
    const Parts parts = share_out(sensors, grasps, threads);
    EXPECT_LE(parts.size(), threads);
    std::vector<std::size_t> part_of(sensors, threads);
    for (std::size_t part = 0; part < parts.size(); ++part) {
      EXPECT_FALSE(parts[part].empty());
      EXPECT_TRUE(std::is_sorted(parts[part].begin(), parts[part].end()));
      for (const std::size_t sensor : parts[part]) {
        EXPECT_EQ(part_of[sensor], threads) << "sensor " << sensor << " is in two threads";
        part_of[sensor] = part;
      }
    }
    for (const std::size_t part : part_of) EXPECT_LT(part, threads) << "a sensor is in no thread";
    for (const auto& grasp : grasps) {
      for (const std::size_t member : grasp) EXPECT_EQ(part_of[member], part_of[grasp.front()]);
    }
  }
}

TEST(EstimateThreads, AreOneForAHandAndMoreForAHundredSensors) {
  const RealtimeSettings settings{.cpus = {0, 1, 2, 3}};
  EXPECT_EQ(estimate_threads(settings, 1), 1U);
  EXPECT_EQ(estimate_threads(settings, 20), 1U);
  EXPECT_EQ(estimate_threads(settings, 64), 1U);
  EXPECT_EQ(estimate_threads(settings, 128), 2U);
}

TEST(EstimateThreads, AreNoMoreThanTheirCpusUnlessConfigured) {
  EXPECT_EQ(estimate_threads({.cpus = {3}}, 128), 1U);
  EXPECT_EQ(estimate_threads({.cpus = {3}, .estimate_threads = 4}, 2), 4U);
}

}  // namespace
}  // namespace slipd
