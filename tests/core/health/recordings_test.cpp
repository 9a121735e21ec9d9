// Recordings of real sensors are never called implausible. They are not part of slipd: tests skip without
// them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "core/chain/chain.hpp"

namespace slipd {
namespace {

// One sensor's values, three a taxel, row by row.
struct Rows {
  std::vector<std::vector<float>> values;
  std::vector<double> time_s;  // empty: the file has none
};

std::filesystem::path recorded() {
  const char* given = std::getenv("SLIPD_SHARED");
  const std::filesystem::path shared = given != nullptr
                                           ? std::filesystem::path(given)
                                           : std::filesystem::path(SLIPD_SOURCE_DIR) / ".." / "shared";
  return shared / "data";
}

Rows read(const std::filesystem::path& file) {
  Rows rows;
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  const bool timed = line.starts_with("time");
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    std::vector<float> values;
    std::string cell;
    for (bool first = true; std::getline(cells, cell, ','); first = false) {
      if (first && timed) {
        rows.time_s.push_back(std::stod(cell));
      } else {
        values.push_back(std::stof(cell));
      }
    }
    rows.values.push_back(std::move(values));
  }
  return rows;
}

struct Sensor {
  TaxelLayout layout;
  std::size_t first_taxel;  // of those in a row
  double pa_per_unit;
  double rate_hz;
  double skin_radius_m;
};

// The zero is the mean of the first rows, or of none where the values have it taken off.
std::vector<double> zero_of(const Rows& rows, std::size_t count) {
  std::vector<double> zero(rows.values.front().size());
  for (std::size_t row = 0; row < count; ++row) {
    for (std::size_t k = 0; k < zero.size(); ++k) zero[k] += rows.values[row][k] / static_cast<double>(count);
  }
  return zero;
}

struct Judged {
  std::size_t frames = 0;
  std::array<std::size_t, kHealths> of{};
};

void play(const Rows& rows, const Sensor& sensor, std::size_t zero_rows, Judged& judged) {
  ChainSetup setup{.layout = sensor.layout, .scene = {}, .estimator = {}, .alerts = {}, .friction = {}};
  setup.scene.skin.radius_m = sensor.skin_radius_m;
  setup.scene.objects = paper_objects();
  EstimatorChain chain(setup, nullptr);
  const std::size_t taxels = sensor.layout.size();
  const auto zero = zero_of(rows, zero_rows);
  std::vector<float> p(taxels), x(taxels), y(taxels);
  for (std::size_t row = 0; row < rows.values.size(); ++row) {
    for (std::size_t i = 0; i < taxels; ++i) {
      const auto value = [&](std::size_t axis) {
        const std::size_t k = 3 * (sensor.first_taxel + i) + axis;
        return static_cast<float>(sensor.pa_per_unit * (static_cast<double>(rows.values[row][k]) - zero[k]));
      };
      x[i] = value(0);
      y[i] = value(1);
      p[i] = value(2);
    }
    const double time_s =
        rows.time_s.empty() ? static_cast<double>(row + 1) / sensor.rate_hz : rows.time_s[row];
    const auto said = chain.estimate({row + 1, 1 + static_cast<std::int64_t>(1e9 * time_s), p, x, y});
    ++judged.frames;
    ++judged.of[static_cast<std::size_t>(said.health)];
  }
}

void expect_all_good(const Judged& judged, const std::string& what) {
  for (std::size_t i = 1; i < kHealths; ++i) {
    if (static_cast<Health>(i) == Health::unexplained) continue;  // a reason why there is no margin
    EXPECT_EQ(judged.of[i], 0U) << to_string(static_cast<Health>(i)) << " in " << judged.frames
                                << " frames of " << what;
  }
}

TEST(RecordedSensors, PillarsAreNeverImplausible) {
  const auto folder = recorded() / "pillars";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "needs ../shared/data/pillars";
  constexpr double kPitch_m = 7e-3;
  const Sensor sensor{TaxelLayout::grid(3, 3, kPitch_m), 0, 1 / (kPitch_m * kPitch_m), 500,
                      std::numeric_limits<double>::infinity()};
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().extension() != ".csv") continue;
    Judged judged;
    play(read(file.path()), sensor, 0, judged);
    expect_all_good(judged, file.path().filename().string());
  }
}

TEST(RecordedSensors, UskinFingertipsAreNeverImplausible) {
  const auto folder = recorded() / "uskin";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "needs ../shared/data/uskin";
  constexpr double kPa = 15;  // a count; about 10 N at full reading
  for (const double skin_radius_m : {0.01, std::numeric_limits<double>::infinity()}) {
    const Sensor sensor{TaxelLayout::grid(4, 4, 4.7e-3), 0, kPa, 60, skin_radius_m};
    for (const auto& file : std::filesystem::recursive_directory_iterator(folder)) {
      if (!file.path().filename().string().starts_with("xela")) continue;
      constexpr std::size_t kZeroRows = 1;
      Judged judged;
      play(read(file.path()), sensor, kZeroRows, judged);
      expect_all_good(judged, file.path().string());
    }
  }
}

TEST(RecordedSensors, MagneticSkinsAreNeverImplausible) {
  const auto folder = recorded() / "eflesh";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "needs ../shared/data/eflesh";
  constexpr double kPa = 10, kSide_m = 5e-3;  // per µT
  for (const double skin_radius_m : {0.01, std::numeric_limits<double>::infinity()}) {
    for (const std::size_t first : {0U, 5U}) {
      const Sensor sensor{TaxelLayout::scattered({0, -kSide_m, kSide_m, 0, 0}, {0, 0, 0, -kSide_m, kSide_m}),
                          first, kPa, 100, skin_radius_m};
      for (const auto& file : std::filesystem::directory_iterator(folder)) {
        if (!file.path().filename().string().starts_with("seq")) continue;
        Judged judged;
        play(read(file.path()), sensor, 5, judged);
        expect_all_good(judged, file.path().filename().string());
      }
    }
  }
}

}  // namespace
}  // namespace slipd
