// The simulated sensor follows its contact model, repeats bit for bit, and has the configured imperfections.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "drivers/sim/simulated_sensor.hpp"
#include "tests/drivers/driver_fixture.hpp"

namespace slipd::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using test::OwnedSlot;

constexpr std::int64_t kMs = 1000000;

// Grip, load until it slips, regrip, unload and reverse, let friction fall, let go.
std::vector<Phase> eventful_cycle() {
  return {{50 * kMs, Ramp{0, 3}, Ramp{0, 0}, {}, 0.6},
          {80 * kMs, {}, {}, Ramp{0, 1.1}, {}},
          {40 * kMs, Ramp{3, 4.5}, {}, {}, {}},
          {60 * kMs, {}, Ramp{1.8, -0.9}, {}, {}},
          {40 * kMs, {}, {}, {}, 0.3},
          {30 * kMs, Ramp{4.5, 0}, {}, {}, {}},
          {20 * kMs, {}, {}, {}, 0.8}};
}

SensorSettings settings_of(std::vector<Phase> cycle) {
  SensorSettings settings;
  settings.cycle = std::move(cycle);
  return settings;
}

double total(std::span<const float> values, const TaxelLayout& layout) {
  return layout.area_m2() * std::accumulate(values.begin(), values.end(), 0.0);
}

// Runs for some ms at 1 kHz and calls check(slot, sensor) for each frame.
template <class Check>
void run(SimulatedSensor& sensor, int frames, Check check) {
  OwnedSlot slot(sensor.layout().size());
  for (int i = 0; i < frames; ++i) {
    sensor.advance(milliseconds(1));
    if (sensor.sample(slot.slot)) check(slot.slot, sensor);
  }
}

TEST(SimulatedSensors, GiveBackTheForcesInTheSumsOfTheirTaxels) {
  for (const auto& layout : {TaxelLayout::grid(100, 100, 0.000144), TaxelLayout::grid(16, 16, 0.001)}) {
    auto settings = settings_of(eventful_cycle());
    settings.offset_x_m = 0.001;
    settings.offset_y_m = -0.0007;
    SimulatedSensor sensor(layout, settings);
    int pressed = 0;
    run(sensor, 320, [&](const FrameSlot& frame, const SimulatedSensor& s) {
      // Floats of 24 bits, averages within 1e-8 of the radius.
      EXPECT_NEAR(total(frame.normal_pa, layout), s.load().normal_n(), 1e-5 * (s.load().normal_n() + 0.01));
      EXPECT_NEAR(total(frame.shear_x_pa, layout), s.load().shear_n(), 1e-5 * (s.load().normal_n() + 0.01));
      EXPECT_EQ(total(frame.shear_y_pa, layout), 0);
      if (s.load().normal_n() > 0) ++pressed;
    });
    EXPECT_GT(pressed, 250);
  }
}

TEST(SimulatedSensors, GiveTheTruthWithEachFrame) {
  SimulatedSensor sensor(TaxelLayout::grid(8, 8, 0.002), settings_of(eventful_cycle()));
  double lowest = 1;
  run(sensor, 960, [&](const FrameSlot& frame, const SimulatedSensor& s) {
    if (s.load().normal_n() == 0) {
      EXPECT_TRUE(std::isnan(frame.truth.gamma));
      EXPECT_TRUE(std::isnan(frame.truth.friction));
      return;
    }
    EXPECT_NEAR(frame.truth.gamma,
                1 - std::fabs(s.load().shear_n()) / (frame.truth.friction * s.load().normal_n()), 1e-12);
    EXPECT_GE(frame.truth.gamma, 0);
    lowest = std::min(lowest, frame.truth.gamma);
  });
  EXPECT_EQ(lowest, 0);
}

TEST(SimulatedSensors, NeverShearMoreThanFrictionHolds) {
  SimulatedSensor sensor(TaxelLayout::grid(40, 40, 0.00036), settings_of(eventful_cycle()));
  run(sensor, 320, [](const FrameSlot& frame, const SimulatedSensor& s) {
    const double peak = s.load().pair().peak_pressure_pa(s.load().normal_n());
    for (std::size_t i = 0; i < frame.normal_pa.size(); ++i) {
      EXPECT_LE(std::fabs(frame.shear_x_pa[i]), s.load().friction() * frame.normal_pa[i] + 1e-6 * peak);
    }
  });
}

TEST(SimulatedSensors, ReachTheSameStateHoweverTimeIsCut) {
  SimulatedSensor coarse(TaxelLayout::grid(8, 8, 0.002), settings_of(eventful_cycle()));
  SimulatedSensor fine(TaxelLayout::grid(8, 8, 0.002), settings_of(eventful_cycle()));
  OwnedSlot a(64), b(64);
  // Steps that no phase is a multiple of, so that corners lie within them.
  for (int i = 0; i < 130; ++i) {
    coarse.advance(nanoseconds(7 * kMs + 1000));
    for (int part = 0; part < 7; ++part) fine.advance(nanoseconds(kMs));
    fine.advance(nanoseconds(1000));
    ASSERT_TRUE(coarse.sample(a.slot));
    ASSERT_TRUE(fine.sample(b.slot));
    EXPECT_NEAR(coarse.load().normal_n(), fine.load().normal_n(), 1e-9);
    EXPECT_NEAR(coarse.load().shear_n(), fine.load().shear_n(), 1e-9);
    for (std::size_t k = 0; k < 64; ++k)
      EXPECT_NEAR(a.slot.shear_x_pa[k], b.slot.shear_x_pa[k], 50) << i;  // of 150 kPa
  }
}

TEST(SimulatedSensors, OfOneForceVectorGiveItWholeWhereverTheContactLies) {
  auto settings = settings_of({{100 * kMs, Ramp{2, 2}, Ramp{0.5, 0.5}, {}, 0.6}});
  settings.offset_x_m = 1;
  for (const auto& layout : {TaxelLayout::wrench(0.02), TaxelLayout::grid(1, 1, 0.02)}) {
    SimulatedSensor sensor(layout, settings);
    run(sensor, 3, [](const FrameSlot& frame, const SimulatedSensor&) {
      EXPECT_FLOAT_EQ(frame.normal_pa[0] * 4e-4F, 2);
      EXPECT_FLOAT_EQ(frame.shear_x_pa[0] * 4e-4F, 0.5);
    });
  }
}

TEST(SimulatedSensors, OfOneSeedRepeatEveryBitAndOfAnotherDoNot) {
  auto settings = settings_of(eventful_cycle());
  settings.imperfections = {7, 0.01, NoiseKind::sensor, 1e5, 0.1, 0, 0.05, 0.1, 1000};
  const auto frames = [&](std::uint64_t seed) {
    settings.imperfections.seed = seed;
    SimulatedSensor sensor(TaxelLayout::grid(10, 10, 0.00144), settings);
    std::vector<float> all;
    run(sensor, 200, [&](const FrameSlot& frame, const SimulatedSensor&) {
      all.push_back(static_cast<float>(frame.sequence));
      for (const auto& values : {frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa})
        all.insert(all.end(), values.begin(), values.end());
    });
    return all;
  };
  const auto first = frames(7);
  EXPECT_EQ(first, frames(7));
  EXPECT_NE(first, frames(8));
}

TEST(SimulatedSensors, AddNoiseOfTheWidthAskedForAndNoBias) {
  for (const auto kind : {NoiseKind::sensor, NoiseKind::relative}) {
    auto settings = settings_of({{100 * kMs, Ramp{2, 2}, {}, Ramp{0.5, 0.5}, 0.6}});
    SimulatedSensor clean(TaxelLayout::grid(50, 50, 0.0003), settings);
    settings.imperfections = {3, 0.02, kind, 2e5};
    SimulatedSensor noisy(TaxelLayout::grid(50, 50, 0.0003), settings);
    OwnedSlot a(2500), b(2500);
    clean.sample(a.slot);
    noisy.sample(b.slot);
    const auto largest = [](std::span<const float> v) { return *std::max_element(v.begin(), v.end()); };
    const float pressure = kind == NoiseKind::sensor ? 4000 : 0.02F * largest(a.slot.normal_pa);
    const float shear = kind == NoiseKind::sensor ? 4000 : 0.02F * largest(a.slot.shear_x_pa);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const float width = channel == 0 ? pressure : shear;
      double sum = 0, squares = 0;
      for (std::size_t i = 0; i < 2500; ++i) {
        const double d = b.memory[2500 * channel + i] - a.memory[2500 * channel + i];
        EXPECT_LE(std::fabs(d), width * 1.001 + 0.1);
        sum += d / width;
        squares += d * d / (width * width);
      }
      EXPECT_NEAR(sum / 2500, 0, 0.06);            // five sigma of the mean of 2500 uniform numbers
      EXPECT_NEAR(squares / 2500, 1.0 / 3, 0.03);  // likewise of their squares
    }
  }
}

TEST(SimulatedSensors, LoseTheShareOfFramesAskedForAndJumpInTheSequence) {
  auto settings = settings_of(eventful_cycle());
  settings.imperfections.drop = 0.2;
  SimulatedSensor sensor(TaxelLayout::grid(2, 2, 0.001), settings);
  std::uint64_t came = 0, jumped = 0, last = 0;
  run(sensor, 20000, [&](const FrameSlot& frame, const SimulatedSensor&) {
    if (came > 0) jumped += frame.sequence - last - 1;
    last = frame.sequence;
    ++came;
  });
  EXPECT_NEAR(static_cast<double>(came) / 20000, 0.8, 0.015);  // five sigma of 20000 throws
  EXPECT_NEAR(static_cast<double>(came + jumped), 20000,
              50);  // all but those before the first and after the last
}

TEST(SimulatedSensors, HaveDeadTaxelsSpreadGainsAndRunningZeros) {
  auto settings = settings_of({{100 * kMs, Ramp{2, 2}, {}, Ramp{0.5, 0.5}, 0.6}});
  const auto layout = TaxelLayout::grid(10, 10, 0.0005);
  SimulatedSensor clean(layout, settings);
  settings.imperfections.dead = 0.13;
  settings.imperfections.gain_spread = 0.2;
  settings.imperfections.drift_pa_s = 500;
  SimulatedSensor faulty(layout, settings);
  ASSERT_EQ(faulty.imperfections().dead().size(), 13U);
  OwnedSlot a(100), b(100);
  clean.advance(milliseconds(2000));
  faulty.advance(milliseconds(2000));
  clean.sample(a.slot);
  faulty.sample(b.slot);
  int differing = 0;
  for (std::uint32_t i = 0; i < 100; ++i) {
    const auto dead = faulty.imperfections().dead();
    if (std::find(dead.begin(), dead.end(), i) != dead.end()) {
      EXPECT_EQ(b.slot.normal_pa[i], 0);
      EXPECT_EQ(b.slot.shear_x_pa[i], 0);
      continue;
    }
    EXPECT_NEAR(b.slot.normal_pa[i], a.slot.normal_pa[i], 0.2 * a.slot.normal_pa[i] + 1000.1);
    EXPECT_LE(std::fabs(b.slot.shear_y_pa[i]), 1000.1);
    if (b.slot.normal_pa[i] != a.slot.normal_pa[i]) ++differing;
  }
  EXPECT_GT(differing, 80);
}

TEST(SimulatedSensors, LetAControllerGripInsteadOfTheScript) {
  SimulatedSensor sensor(TaxelLayout::grid(8, 8, 0.002),
                         settings_of({{100 * kMs, Ramp{2, 2}, Ramp{0.9, 0.9}, {}, 0.5}}));
  sensor.advance(milliseconds(1));
  EXPECT_NEAR(sensor.truth().gamma, 0.1, 1e-12);
  sensor.grip(3.6);
  sensor.advance(milliseconds(1));
  EXPECT_NEAR(sensor.truth().gamma, 0.5, 1e-12);  // the object hangs on with the same weight
  sensor.grip(std::nullopt);
  sensor.advance(milliseconds(1));
  EXPECT_NEAR(sensor.truth().gamma, 0.1, 1e-12);
  sensor.grip(kUnknown);
  sensor.advance(milliseconds(1));
  EXPECT_TRUE(std::isnan(sensor.truth().gamma));
}

// Grip, pull with a twist, twist on until it slides, twist back, let go.
std::vector<Phase> twisting_cycle() {
  return {
      {50 * kMs, Ramp{0, 3}, Ramp{0, 0}, {}, 0.6},    {60 * kMs, {}, Ramp{0, 0.8}, {}, {}, Ramp{0, 0.001}},
      {60 * kMs, {}, {}, {}, {}, Ramp{0.001, 0.004}}, {60 * kMs, {}, {}, {}, {}, Ramp{0.002, -0.001}},
      {40 * kMs, Ramp{3, 2.5}, {}, {}, {}},           {30 * kMs, Ramp{2.5, 0}, {}, {}, {}, Ramp{0, 0}}};
}

TEST(SimulatedSensorsWithATorque, CarryForceAndTorqueInTheSumsOfTheirTaxelsWithinFriction) {
  for (const auto& layout : {TaxelLayout::grid(32, 32, 0.00045), TaxelLayout::grid(16, 16, 0.001)}) {
    auto settings = settings_of(twisting_cycle());
    settings.offset_x_m = 0.001;
    SimulatedSensor sensor(layout, settings);
    int turned = 0, slid = 0;
    run(sensor, 270, [&](const FrameSlot& frame, const SimulatedSensor& s) {
      double torque_nm = 0;
      for (std::size_t i = 0; i < layout.size(); ++i) {
        const auto p = static_cast<double>(frame.normal_pa[i]);
        const auto x = static_cast<double>(frame.shear_x_pa[i]), y = static_cast<double>(frame.shear_y_pa[i]);
        EXPECT_LE(std::hypot(x, y), 0.6 * p * (1 + 1e-4) + 1e-2);
        torque_nm += layout.area_m2() * ((layout.x_m()[i] - 0.001) * y - layout.y_m()[i] * x);
      }
      if (!s.turning()->active()) return;
      ++turned;
      if (s.truth().gamma < 0.01) {
        ++slid;
        return;
      }
      const auto& load = s.turning()->load();
      const double most_n = 0.6 * s.turning()->normal_n();
      EXPECT_NEAR(total(frame.shear_x_pa, layout), load.shear_x_n, 0.012 * most_n);
      EXPECT_NEAR(total(frame.shear_y_pa, layout), 0, 0.012 * most_n);
      // A taxel's shear is a mean: the torque within it is lost.
      const double coarse = layout.side_m() / s.turning()->contact_radius_m();
      EXPECT_NEAR(torque_nm, load.torque_nm,
                  (0.012 + 0.15 * coarse * coarse) * most_n * s.turning()->contact_radius_m());
    });
    EXPECT_GT(turned, 150);
    EXPECT_GT(slid, 10);
  }
}

TEST(SimulatedSensorsWithATorque, PlayWhatComesBeforeTheTorqueBitForBit) {
  const auto layout = TaxelLayout::grid(32, 32, 0.00045);
  auto with = settings_of(eventful_cycle()), without = with;
  with.cycle.push_back({20 * kMs, {}, {}, {}, {}, Ramp{0.001, 0}});
  without.cycle.push_back({20 * kMs, {}, {}, {}, {}});
  SimulatedSensor turned(layout, with), plain(layout, without);
  EXPECT_EQ(plain.turning(), nullptr);
  OwnedSlot a(layout.size()), b(layout.size());
  for (int i = 0; i < 310; ++i) {
    turned.advance(milliseconds(1));
    plain.advance(milliseconds(1));
    ASSERT_TRUE(turned.sample(a.slot) && plain.sample(b.slot));
    EXPECT_TRUE(std::ranges::equal(a.slot.shear_x_pa, b.slot.shear_x_pa)) << i;
    EXPECT_TRUE(std::ranges::equal(a.slot.normal_pa, b.slot.normal_pa));
    EXPECT_TRUE(a.slot.truth.gamma == b.slot.truth.gamma ||
                (std::isnan(a.slot.truth.gamma) && std::isnan(b.slot.truth.gamma)));
  }
}

// Beside its centre of mass an object slides at a lighter force; `load` counts both.
TEST(SimulatedSensorsWithATorque, OfALeverSlideWhereLoadIsOne) {
  const auto layout = TaxelLayout::grid(32, 32, 0.00045);
  auto settings = settings_of({{20 * kMs, Ramp{0, 2}, {}, {}, 0.5}, {100 * kMs, {}, {}, Ramp{0, 1}, {}}});
  settings.lever_m = 0.02;
  SimulatedSensor sensor(layout, settings);
  sensor.advance(milliseconds(70));
  EXPECT_NEAR(sensor.truth().gamma, 0.5, 1e-3);
  EXPECT_LT(sensor.load().shear_n(), 0.1 * 0.5 * 2);
  sensor.advance(milliseconds(49));
  EXPECT_NEAR(sensor.truth().gamma, 0.01, 2e-3);
}

TEST(SimulatedSensorsWithATorque, NeedSeveralTaxelsAndTheIdealContact) {
  auto settings = settings_of(twisting_cycle());
  EXPECT_THROW(SimulatedSensor(TaxelLayout::wrench(0.02), settings), std::invalid_argument);
  settings.preset = Preset::pillars;
  EXPECT_THROW(SimulatedSensor(TaxelLayout::grid(3, 3, 0.007), settings), std::invalid_argument);
}

TEST(Scripts, HoldWhatAPhaseDoesNotSayAndGoRoundForEver) {
  const Script script({{10, Ramp{0, 4}, {}, {}, 0.5}, {10, {}, {}, Ramp{0, 2}, {}}, {10, {}, {}, {}, {}}});
  const auto at = [&](std::int64_t t) {
    LoadTarget last;
    script.walk(t, t, [&](const LoadTarget& d) { last = d; });
    return last;
  };
  EXPECT_EQ(at(5).normal_n, 2);
  EXPECT_EQ(at(15).normal_n, 4);
  EXPECT_EQ(at(15).shear_n(4), 2);
  EXPECT_EQ(at(25).shear_n(4), 2);  // asked for 4, friction held 2
  EXPECT_EQ(at(35).normal_n, 2);
  EXPECT_EQ(at(35).shear_n(4), 2);  // what the end leaves is what the next round begins with
}

TEST(Scripts, VisitEveryCornerBetweenTwoMoments) {
  const Script script({{10, Ramp{0, 4}, {}, {}, {}}, {10, Ramp{1, 3}, {}, {}, {}}});
  std::vector<double> normals;
  script.walk(5, 25, [&](const LoadTarget& d) { normals.push_back(d.normal_n); });
  EXPECT_EQ(normals, (std::vector<double>{4, 1, 3, 0, 2}));
  int visits = 0;
  script.walk(0, 1000000000, [&](const LoadTarget&) { ++visits; });
  EXPECT_LE(visits, 7);  // a long sleep costs one round, not all of them
}

TEST(Scripts, ThatAreInvalidAreRefusedWithThePhase) {
  const auto refusal = [](std::vector<Phase> cycle) -> std::string {
    try {
      Script{cycle};
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "";
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(refusal({}), HasSubstr("at least one phase"));
  EXPECT_THAT(refusal({{10, {}, {}, {}, {}}, {0, {}, {}, {}, {}}}), HasSubstr("cycle/1"));
  EXPECT_THAT(refusal({{10, Ramp{0, -1}, {}, {}, {}}}), HasSubstr("negative"));
  EXPECT_THAT(refusal({{10, Ramp{0, kUnknown}, {}, {}, {}}}), HasSubstr("finite"));
  EXPECT_THAT(refusal({{10, {}, Ramp{0, 1}, Ramp{0, 1}, {}}}), HasSubstr("not both"));
  EXPECT_THAT(refusal({{10, {}, {}, {}, 0.0}}), HasSubstr("friction"));
}

}  // namespace
}  // namespace slipd::sim
