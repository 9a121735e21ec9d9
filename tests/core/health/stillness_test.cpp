// Values that stop to change are noticed where they had noise, and only there.
#include "core/health/stillness.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace slipd {
namespace {

// A group of values with the bookkeeping of Probes.
class Group {
 public:
  explicit Group(std::size_t size) : last_(size), way_(size) {}

  GroupChange to(const std::vector<double>& values) {
    GroupChange change{.values = values.size()};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double step = values[i] - last_[i];
      last_[i] = values[i];
      if (step == 0) continue;
      ++change.changed;
      change.turned += step * way_[i] < 0 ? 1 : 0;
      way_[i] = step;
    }
    return change;
  }

 private:
  std::vector<double> last_, way_;
};

class StillnessOf : public ::testing::Test {
 protected:
  std::vector<double> noise(double step = 0) {
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<double> values(kValues);
    for (double& value : values) {
      value = unit(random_);
      if (step > 0) value = step * std::round(value / step);
    }
    return values;
  }

  static constexpr std::size_t kValues = 16;
  std::mt19937_64 random_{1};
  Group group_{kValues};
  Stillness stillness_;
};

TEST_F(StillnessOf, NoiseThatStopsIsNoticedAtOnce) {
  for (int i = 0; i < 100; ++i) ASSERT_FALSE(stillness_.update(group_.to(noise())));
  const auto last = noise();
  EXPECT_FALSE(stillness_.update(group_.to(last)));
  EXPECT_TRUE(stillness_.update(group_.to(last)));
}

TEST_F(StillnessOf, ALoadWithoutNoiseMayStandStill) {
  for (int i = 0; i < 200; ++i) {
    const double load = i;
    ASSERT_FALSE(stillness_.update(group_.to(std::vector<double>(kValues, load))));
  }
  for (int i = 0; i < 1000; ++i)
    ASSERT_FALSE(stillness_.update(group_.to(std::vector<double>(kValues, 199))));
}

TEST_F(StillnessOf, ValuesThatRepeatBecauseTheyAreQuantisedAreNoStandstill) {
  constexpr double kStep = 1.5;  // a value in three is not 0
  int alarms = 0;
  for (int i = 0; i < 200000; ++i) alarms += stillness_.update(group_.to(noise(kStep))) ? 1 : 0;
  EXPECT_EQ(alarms, 0);
}

TEST_F(StillnessOf, ADeviceThatGivesEachFrameThreeTimesIsNoStandstill) {
  std::vector<double> values = noise();
  for (int i = 0; i < 3000; ++i) {
    if (i % 3 == 0) values = noise();
    ASSERT_FALSE(stillness_.update(group_.to(values))) << i;
  }
}

}  // namespace
}  // namespace slipd
