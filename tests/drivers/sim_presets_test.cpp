// The presets of the simulated sensor: what recordings of such sensors show, with the truth beside it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "drivers/sim/simulated_sensor.hpp"
#include "tests/drivers/driver_fixture.hpp"

namespace slipd::sim {
namespace {

using std::chrono::milliseconds;
using test::OwnedSlot;

constexpr std::int64_t kMs = 1000000;
constexpr double kFlat = std::numeric_limits<double>::infinity();

const auto kPillarLayout = TaxelLayout::grid(3, 3, 0.007);
const auto kMagnetLayout = TaxelLayout::grid(4, 4, 0.0047);

// 100 ms without contact, closing in 90 ms, 1 s of hold; then the load rises to `load` of what holds in 200
// ms and stays.
SensorSettings grasp(Preset preset, double load, double normal_n = 5) {
  SensorSettings settings;
  settings.preset = preset;
  settings.skin = {kFlat, preset == Preset::pillars ? 1e6 : 0.5e6, 0.45};
  settings.imperfections.seed = 3;
  settings.cycle = {{100 * kMs, Ramp{0, 0}, {}, Ramp{0, 0}, 0.5},
                    {90 * kMs, Ramp{0, normal_n}, {}, {}, {}},
                    {1000 * kMs, {}, {}, {}, {}},
                    {200 * kMs, {}, {}, Ramp{0, load}, {}},
                    {1000 * kMs, {}, {}, {}, {}}};
  return settings;
}
constexpr int kClosed_ms = 190, kHeld_ms = 1190, kLoaded_ms = 1390, kEnd_ms = 2389;

struct Shown {
  std::vector<float> normal, x, y;
  double normal_n = 0, shear_n = 0, sum_shear_n = 0;
  Truth truth;
};

// A frame each ms.
std::vector<Shown> play(const TaxelLayout& layout, const SensorSettings& settings, int ms) {
  SimulatedSensor sensor(layout, settings);
  OwnedSlot slot(layout.size());
  std::vector<Shown> frames;
  for (int i = 0; i < ms; ++i) {
    sensor.advance(milliseconds(1));
    if (!sensor.sample(slot.slot)) continue;
    const auto copied = [](std::span<float> from) { return std::vector<float>(from.begin(), from.end()); };
    Shown shown{copied(slot.slot.normal_pa),
                copied(slot.slot.shear_x_pa),
                copied(slot.slot.shear_y_pa),
                0,
                0,
                0,
                slot.slot.truth};
    double x_n = 0, y_n = 0;
    for (std::size_t k = 0; k < layout.size(); ++k) {
      const double a = layout.area_m2(), qx = a * static_cast<double>(shown.x[k]),
                   qy = a * static_cast<double>(shown.y[k]);
      shown.normal_n += a * static_cast<double>(shown.normal[k]);
      shown.sum_shear_n += std::hypot(qx, qy);
      x_n += qx;
      y_n += qy;
    }
    shown.shear_n = std::hypot(x_n, y_n);
    frames.push_back(std::move(shown));
  }
  return frames;
}

double pattern_moved(const Shown& now, const Shown& then) {
  double sum = 0, all_now = 0, all_then = 0;
  for (const float p : now.normal) all_now += static_cast<double>(p);
  for (const float p : then.normal) all_then += static_cast<double>(p);
  for (std::size_t i = 0; i < now.normal.size(); ++i)
    sum += std::fabs(static_cast<double>(now.normal[i]) / all_now -
                     static_cast<double>(then.normal[i]) / all_then);
  return sum / 2;
}

TEST(PillarPreset, OvershootsRelaxesAndFeelsShearThatNobodyPulls) {
  const auto frames = play(kPillarLayout, grasp(Preset::pillars, 0), kHeld_ms);
  double peak_n = 0;
  for (const Shown& frame : frames) peak_n = std::max(peak_n, frame.normal_n);
  const Shown& held = frames.back();
  EXPECT_NEAR(held.normal_n, 5, 0.5);
  EXPECT_NEAR(peak_n / held.normal_n, 3.5, 0.3) << "as recordings of pillars";
  EXPECT_NEAR(held.sum_shear_n / held.normal_n, 0.15, 0.07);
  EXPECT_LT(held.shear_n / held.normal_n, 0.08);
  EXPECT_GT(held.truth.gamma, 0.97) << "shaking only";
}

TEST(PillarPreset, HasPillarsBelowZero) {
  auto settings = grasp(Preset::pillars, 0.9, 1);
  int below = 0;
  for (const Shown& frame : play(kPillarLayout, settings, kEnd_ms))
    below += *std::min_element(frame.normal.begin(), frame.normal.end()) < -100 ? 1 : 0;
  EXPECT_GT(below, 100);
}

TEST(MagneticPreset, FeelsAPullAsPressureAheadAndSuctionBehind) {
  // A ball, so that the outer taxels carry nothing.
  auto settings = grasp(Preset::magnetic_skin, 0.9, 2);
  settings.object.radius_m = 0.03;
  const auto frames = play(kMagnetLayout, settings, kLoaded_ms);
  const auto column = [](const Shown& frame, std::size_t x) {
    double sum = 0;
    for (std::size_t y = 0; y < 4; ++y) sum += static_cast<double>(frame.normal[4 * y + x]) / frame.normal_n;
    return sum;
  };
  const Shown &unpulled = frames[kHeld_ms - 1], &pulled = frames.back();
  EXPECT_LT(column(pulled, 0), column(unpulled, 0));
  EXPECT_GT(column(pulled, 3), column(unpulled, 3));
}

class EveryPreset : public testing::TestWithParam<Preset> {
 protected:
  const TaxelLayout& layout() const { return GetParam() == Preset::pillars ? kPillarLayout : kMagnetLayout; }
};
INSTANTIATE_TEST_SUITE_P(, EveryPreset, testing::Values(Preset::pillars, Preset::magnetic_skin),
                         [](const auto& which) {
                           return which.param == Preset::pillars ? "pillars" : "magnetic_skin";
                         });

TEST_P(EveryPreset, ShowsAHoldInAPatternThatStaysAndASlideInOneThatMoves) {
  const auto held = play(layout(), grasp(GetParam(), 0.6), kEnd_ms);
  EXPECT_LT(pattern_moved(held[kEnd_ms - 1], held[kLoaded_ms + 200]), 0.03);
  // A hold after a load keeps the newtons that the nominal friction gave; shaking is the tolerance.
  EXPECT_NEAR(held.back().truth.gamma, 1 - 0.6 * 0.5 / held.back().truth.friction, 0.03);
  const auto slid = play(layout(), grasp(GetParam(), 1.1), kEnd_ms);
  double moved = 0;
  for (int i = kLoaded_ms; i < kEnd_ms; i += 20)
    moved = std::max(moved, pattern_moved(slid[static_cast<std::size_t>(i)], slid[kHeld_ms - 1]));
  EXPECT_GT(moved, 0.06);
  EXPECT_EQ(slid.back().truth.gamma, 0);
}

TEST_P(EveryPreset, GivesTheTruthOfFrictionWithOneSlipperySide) {
  const auto frames = play(layout(), grasp(GetParam(), 1.1), kEnd_ms);
  EXPECT_TRUE(std::isnan(frames.front().truth.gamma));
  EXPECT_GT(frames[kHeld_ms].truth.friction, 0.8 * 0.5);
  EXPECT_LT(frames[kHeld_ms].truth.friction, 0.5);
}

TEST_P(EveryPreset, RepeatsBitForBitAndDiffersBySeed) {
  auto settings = grasp(GetParam(), 1.1);
  settings.imperfections.noise = 0.01;
  const auto once = play(layout(), settings, 1400), again = play(layout(), settings, 1400);
  settings.imperfections.seed = 4;
  const auto other = play(layout(), settings, 1400);
  for (std::size_t i = 0; i < once.size(); ++i) {
    ASSERT_EQ(once[i].normal, again[i].normal) << i;
    ASSERT_EQ(once[i].x, again[i].x) << i;
    ASSERT_EQ(once[i].y, again[i].y) << i;
  }
  EXPECT_NE(once.back().normal, other.back().normal);
}

TEST_P(EveryPreset, IsCutOffAtTheEndOfItsRange) {
  const auto range = effects_of(GetParam()).value().range;
  const auto frames = play(layout(), grasp(GetParam(), 0, 300), kHeld_ms);
  float most = 0;
  for (const Shown& frame : frames)
    most = std::max(most, *std::max_element(frame.normal.begin(), frame.normal.end()));
  EXPECT_EQ(most, static_cast<float>(range.normal_pa));
}

TEST_P(EveryPreset, IsRefusedForOneForceVector) {
  EXPECT_THROW(SimulatedSensor(TaxelLayout::wrench(0.02), grasp(GetParam(), 0)), std::invalid_argument);
}

TEST_P(EveryPreset, HoldsOnWhileAControllerGripsHarder) {
  auto settings = grasp(GetParam(), 0);
  settings.cycle = {{1000 * kMs, Ramp{5, 5}, Ramp{2, 2}, {}, 0.5}};
  SimulatedSensor sensor(layout(), settings);
  for (int i = 0; i < 600; ++i) sensor.advance(milliseconds(1));
  const double before = sensor.truth().gamma;
  sensor.grip(10);
  for (int i = 0; i < 600; ++i) sensor.advance(milliseconds(1));
  EXPECT_GT(sensor.truth().gamma, before + 0.2);
}

}  // namespace
}  // namespace slipd::sim
