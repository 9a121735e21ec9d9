// A replay of two recorded magnetic fingertips returns each row, and the slip in it shows Coulomb's plateau.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "tests/drivers/replay_fixture.hpp"

namespace slipd::replay {
namespace {

using test::opening;
using test::play_whole;
using test::setup_of;

constexpr std::size_t kTaxels = 16;

// Where the recorded grasps of two real sensors are, if they are here at all.
std::filesystem::path real_grasps() {
  const char* given = std::getenv("SLIPD_SHARED");
  const std::filesystem::path shared = given != nullptr
                                           ? std::filesystem::path(given)
                                           : std::filesystem::path(SLIPD_SOURCE_DIR) / ".." / "shared";
  return shared / "data/uskin";
}

constexpr const char* kNoGrasps =
    "needs the recorded grasps in ../shared/data/uskin (SLIPD_SHARED names another ../shared)";

SensorSetup real_sensor(const std::filesystem::path& file, nlohmann::json bias) {
  return setup_of(TaxelLayout::grid(4, 4, 0.0047),
                  {{"file", file.string()}, {"speed", 0}, {"bias", std::move(bias)}}, 60);
}

TEST(ReplaysOfRecordedFingertips, GiveEachRow) {
  if (!std::filesystem::exists(real_grasps())) GTEST_SKIP() << kNoGrasps;
  const std::vector<std::pair<const char*, std::size_t>> trials{
      {"2022-02-21-09-58-49", 404}, {"2022-02-21-14-10-49", 354}, {"2022-02-22-15-15-00", 259}};
  for (const auto& [trial, rows] : trials) {
    for (const char* name : {"xela_sensor1.csv", "xela_sensor2.csv"}) {
      const auto played = play_whole(real_sensor(real_grasps() / trial / name, {16000, 16000, 37500}));
      EXPECT_EQ(played.frames.size(), rows) << trial << name;
      EXPECT_EQ(played.last, ReadStatus::end);
    }
    EXPECT_THAT(opening(real_sensor(real_grasps() / trial, 0)),
                ::testing::HasSubstr("name the file of the tactile sensor"));
  }
}

// The object slips from row 73 on by the camera's label and has been let go by row 140: the only zero there
// is.
TEST(ReplaysOfRecordedFingertips, ShowCoulombsPlateauWithTheZeroOfEachTaxelTakenOff) {
  if (!std::filesystem::exists(real_grasps())) GTEST_SKIP() << kNoGrasps;
  const auto file = real_grasps() / "2022-02-22-15-15-00/xela_sensor2.csv";
  const auto raw = play_whole(real_sensor(file, 0));
  ASSERT_EQ(raw.values.size(), 259U);
  std::vector<double> zero(3 * kTaxels);
  for (std::size_t row = 140; row < 259; ++row) {
    for (std::size_t i = 0; i < kTaxels; ++i) {
      const auto& v = raw.values[row];
      const double axes[] = {v[kTaxels + i], v[2 * kTaxels + i], v[i]};
      for (std::size_t axis = 0; axis < 3; ++axis) zero[3 * i + axis] += axes[axis] / 119;
    }
  }
  const auto played = play_whole(real_sensor(file, zero));
  std::vector<double> ratio;
  for (const auto& v : played.values) {
    double sums[3] = {0, 0, 0};
    for (std::size_t k = 0; k < 3 * kTaxels; ++k) sums[k / kTaxels] += v[k];
    ratio.push_back(std::hypot(sums[1], sums[2]) / sums[0]);
  }
  const auto mean = [&](std::size_t from, std::size_t to) {
    double sum = 0;
    for (std::size_t i = from; i < to; ++i) sum += ratio[i];
    return sum / static_cast<double>(to - from);
  };
  EXPECT_NEAR(mean(0, 50), 0.39, 0.015);                                     // held
  EXPECT_GT(*std::max_element(&ratio[55], &ratio[73]), mean(0, 50) + 0.03);  // rises before the label comes
  EXPECT_NEAR(mean(78, 114), 0.415, 0.025);  // friction's plateau while it slips
}

}  // namespace
}  // namespace slipd::replay
