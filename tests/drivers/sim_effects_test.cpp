// Each effect of the simulated presets by itself, against what its own theory says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "drivers/sim/effects/axis_tilt.hpp"
#include "drivers/sim/effects/coloured_noise.hpp"
#include "drivers/sim/effects/presets.hpp"
#include "drivers/sim/effects/rough_contact.hpp"
#include "drivers/sim/effects/shaking.hpp"
#include "drivers/sim/effects/skin_layer.hpp"
#include "drivers/sim/effects/standard_linear_solid.hpp"
#include "drivers/sim/effects/texture.hpp"

namespace slipd::sim {
namespace {

constexpr double kStep_s = 0.001;
constexpr std::uint64_t kSeed = 5;

double sum_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(StandardLinearSolids, RelaxAfterAStepAsAnExponential) {
  StandardLinearSolid rubber({.stiffening = 4, .relaxation_s = 0.1});
  rubber.update(0, kStep_s);
  EXPECT_NEAR(rubber.update(2, 0), 8, 1e-12);
  for (int ms = 1; ms <= 500; ++ms) {
    const double force_n = rubber.update(2, kStep_s);
    ASSERT_NEAR(force_n, 2 * (1 + 3 * std::exp(-ms * kStep_s / 0.1)), 1e-9) << ms;
  }
}

TEST(StandardLinearSolids, OvershootARampAsFarHoweverTimeIsCut) {
  StandardLinearSolid fine({.stiffening = 5, .relaxation_s = 0.09});
  StandardLinearSolid coarse({.stiffening = 5, .relaxation_s = 0.09});
  double peak_n = 0;
  for (int ms = 1; ms <= 90; ++ms) peak_n = fine.update(ms / 90.0, kStep_s);
  EXPECT_NEAR(peak_n, coarse.update(1, 0.09), 1e-9);
  // Of a ramp as long as the relaxation: 1 + (stiffening - 1)(1 - 1/e).
  EXPECT_NEAR(peak_n, 1 + 4 * (1 - std::exp(-1)), 1e-9);
}

TEST(StandardLinearSolids, LetGoAndNeverPullWhileTheyOpen) {
  StandardLinearSolid rubber({.stiffening = 5, .relaxation_s = 0.09});
  rubber.update(5, 0.1);
  for (int ms = 0; ms < 2000; ++ms) rubber.update(5, kStep_s);
  EXPECT_NEAR(rubber.update(5, kStep_s), 5, 1e-6);
  EXPECT_EQ(rubber.update(1, 0.001), 0);
}

TEST(StandardLinearSolids, OfStiffeningOneAreElastic) {
  StandardLinearSolid rubber({});
  EXPECT_EQ(rubber.update(3, kStep_s), 3);
  EXPECT_EQ(rubber.update(1, kStep_s), 1);
}

TEST(Shakings, HaveTheSizeAskedForAndNoMean) {
  const Shaking shaking({.share = 0.01, .lowest_hz = 10, .highest_hz = 40}, kSeed);
  constexpr int kSamples = 100000;
  double sum = 0, squares = 0, both = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double normal = shaking.normal(i * kStep_s), shear = shaking.shear(i * kStep_s);
    sum += normal;
    squares += normal * normal;
    both += normal * shear;
  }
  EXPECT_NEAR(sum / kSamples, 0, 1e-4);
  EXPECT_NEAR(std::sqrt(squares / kSamples), 0.01, 3e-4);  // beats of six waves over 100 s
  EXPECT_NEAR(both / squares, 0, 0.05) << "the two directions shake by themselves";
  EXPECT_EQ(Shaking({}, kSeed).normal(1), 0);
}

TEST(Textures, AreAsRoughAsAskedForAndDifferBySeed) {
  const TextureSettings settings{.rms_m = 20e-6, .shortest_m = 0.005, .longest_m = 0.02};
  const Texture one(settings, 1), same(settings, 1), other(settings, 2);
  double squares = 0, differences = 0;
  int count = 0;
  for (double x = 0; x < 1; x += 0.0021) {
    for (double y = 0; y < 1; y += 0.021) {
      EXPECT_EQ(one.height_m(x, y), same.height_m(x, y));
      squares += std::pow(one.height_m(x, y), 2);
      differences += std::pow(one.height_m(x, y) - other.height_m(x, y), 2);
      ++count;
    }
  }
  EXPECT_NEAR(std::sqrt(squares / count), 20e-6, 1e-6);
  EXPECT_NEAR(differences / squares, 2, 0.2) << "independent reliefs";
}

struct Taxels {
  explicit Taxels(std::size_t count) : normal(count), x(count), y(count) {}
  void tilt(const AxisTilt& by) { by.apply(normal, x, y); }
  std::vector<float> normal, x, y;
};

TEST(AxisTilts, TurnForcesAndKeepTheirSize) {
  const auto layout = TaxelLayout::grid(4, 3, 0.007);
  const AxisTilt tilt({.base_radius_m = 0.05, .spread_rad = 0.1}, layout, kSeed);
  Taxels taxels(layout.size());
  for (std::size_t i = 0; i < layout.size(); ++i) {
    taxels.normal[i] = 3;
    taxels.x[i] = -1;
    taxels.y[i] = 2;
  }
  taxels.tilt(tilt);
  for (std::size_t i = 0; i < layout.size(); ++i) {
    EXPECT_NEAR(std::hypot(taxels.normal[i], taxels.x[i], taxels.y[i]), std::sqrt(14.0), 1e-5);
    EXPECT_NE(taxels.normal[i], 3);
  }
}

TEST(AxisTilts, OfACurvedBaseFeelPressingAsOutwardShearAndAPullAsSuction) {
  const auto layout = TaxelLayout::grid(3, 3, 0.007);
  const AxisTilt tilt({.base_radius_m = 0.05}, layout, kSeed);
  Taxels pressed(9), pulled(9);
  std::fill(pressed.normal.begin(), pressed.normal.end(), 1.0F);
  std::fill(pulled.x.begin(), pulled.x.end(), 1.0F);
  pressed.tilt(tilt);
  pulled.tilt(tilt);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(pressed.x[i], layout.x_m()[i] / 0.05, 2e-3);
    EXPECT_NEAR(pressed.y[i], layout.y_m()[i] / 0.05, 2e-3);
    EXPECT_NEAR(pulled.normal[i], -layout.x_m()[i] / 0.05, 2e-3);
  }
  EXPECT_LT(pulled.normal[5], -0.1) << "the taxel that leans the way of the pull";
}

TEST(AxisTilts, OfAFlatBaseWithoutSpreadChangeNothing) {
  Taxels taxels(4);
  taxels.normal = {1, 2, 3, 4};
  taxels.x = {4, 3, 2, 1};
  taxels.tilt(AxisTilt({}, TaxelLayout::grid(2, 2, 0.004), kSeed));
  EXPECT_THAT(taxels.normal, testing::ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(taxels.x, testing::ElementsAre(4, 3, 2, 1));
  EXPECT_THAT(taxels.y, testing::Each(0));
}

// A frame of zeros with noise.
std::vector<float> noisy(ColouredNoise& noise, std::uint64_t number, double time_s, std::size_t taxels) {
  std::vector<float> memory(3 * taxels);
  const std::span all(memory);
  const std::array<std::span<float>, 3> channels{all.first(taxels), all.subspan(taxels, taxels),
                                                 all.last(taxels)};
  noise.add(channels, number, time_s);
  return memory;
}

double product(const std::vector<std::vector<float>>& frames, std::size_t a, std::size_t b, std::size_t lag) {
  double sum = 0;
  for (std::size_t i = lag; i < frames.size(); ++i)
    sum += static_cast<double>(frames[i][a]) * static_cast<double>(frames[i - lag][b]);
  return sum / static_cast<double>(frames.size() - lag);
}

TEST(ColouredNoises, HaveTheSizeAndTheCorrelationsAskedFor) {
  ColouredNoise noise({.sigma_pa = 100, .correlation_s = 0.02, .common = 0.3}, 4, kSeed);
  std::vector<std::vector<float>> frames;
  for (std::uint64_t i = 0; i < 100000; ++i)
    frames.push_back(noisy(noise, i, static_cast<double>(i) * 0.002, 4));
  // 200 s hold 10000 independent values: three sigma of a variance are 4 %, of a correlation 3 %.
  EXPECT_NEAR(product(frames, 1, 1, 0), 1e4, 500);
  EXPECT_NEAR(product(frames, 1, 1, 10), 1e4 * std::exp(-1), 500) << "after the correlation time";
  EXPECT_NEAR(product(frames, 1, 2, 0), 0.3e4, 500) << "two taxels of one channel";
  EXPECT_NEAR(product(frames, 1, 5, 0), 0, 500) << "two channels of one taxel";
}

TEST(ColouredNoises, FromZeroBeginThereAndGrow) {
  ColouredNoise drift({.sigma_pa = 100, .correlation_s = 60, .from_zero = true}, 16, kSeed);
  EXPECT_THAT(noisy(drift, 0, 0, 16), testing::Each(0));
  const auto squares = [](const std::vector<float>& values) {
    return std::inner_product(values.begin(), values.end(), values.begin(), 0.0) /
           static_cast<double>(values.size());
  };
  EXPECT_LT(squares(noisy(drift, 1, 0.6, 16)), 1e4 * 0.05) << "after a hundredth of the time: about 2 %";
  EXPECT_NEAR(squares(noisy(drift, 2, 1000, 16)), 1e4, 6e3);
}

TEST(SkinLayers, CarryTheWholeForceToWideEnoughAPad) {
  const auto layout = TaxelLayout::grid(120, 120, 0.0005);
  const std::vector<double> x{0.0011}, y{-0.0007}, normal{2}, shear{0.5};
  const SkinLayer skin(layout, x, y, 0.002);
  Taxels sensed(layout.size());
  skin.sense(normal, shear, sensed.normal, sensed.x, sensed.y);
  const auto total = [&](const std::vector<float>& values) {
    return layout.area_m2() * std::accumulate(values.begin(), values.end(), 0.0);
  };
  EXPECT_NEAR(total(sensed.normal), 2, 0.01);
  EXPECT_NEAR(total(sensed.x), 0.5 * (1 - 0.09), 0.01);  // beyond r lie 3 d/(2 r) of it, a tenth beyond 30 mm
  EXPECT_NEAR(total(sensed.y), 0, 0.01);
}

TEST(SkinLayers, FeelPressingAsOutwardShearAndAPullAsPressureAheadAndSuctionBehind) {
  const auto layout = TaxelLayout::grid(5, 1, 0.002);
  const std::vector<double> at{0}, none{0}, one{1};
  const SkinLayer skin(layout, at, at, 0.002);
  Taxels pressed(5), pulled(5);
  skin.sense(one, none, pressed.normal, pressed.x, pressed.y);
  skin.sense(none, one, pulled.normal, pulled.x, pulled.y);
  EXPECT_LT(pressed.x[1], 0);
  EXPECT_GT(pressed.x[3], 0);
  EXPECT_LT(pulled.normal[1], 0);
  EXPECT_GT(pulled.normal[3], 0);
  // Right above a taxel: 3 P/(2 pi d^2).
  EXPECT_NEAR(pressed.normal[2], 3 / (2 * 3.14159265 * 4e-6), 1);
}

TEST(SkinLayers, OnceCalibratedFeelAnEvenLoadWhole) {
  const auto layout = TaxelLayout::grid(4, 4, 0.0047);
  std::vector<double> x, y, normal, shear;
  for (int row = 0; row < 12; ++row) {
    for (int column = 0; column < 12; ++column) {
      x.push_back((column - 5.5) * 0.0047 / 3);
      y.push_back((row - 5.5) * 0.0047 / 3);
      normal.push_back(3.0 / 144);
      shear.push_back(-1.0 / 144);
    }
  }
  SkinLayer skin(layout, x, y, 0.0025);
  const auto sensed_n = [&] {
    Taxels sensed(16);
    skin.sense(normal, shear, sensed.normal, sensed.x, sensed.y);
    const auto total = [&](const std::vector<float>& values) {
      return layout.area_m2() * std::accumulate(values.begin(), values.end(), 0.0);
    };
    return std::pair(total(sensed.normal), total(sensed.x));
  };
  EXPECT_LT(sensed_n().first, 2.9) << "its edges are not sensed";
  skin.calibrate(layout.area_m2());
  EXPECT_NEAR(sensed_n().first, 3, 1e-4);
  EXPECT_NEAR(sensed_n().second, -1, 1e-4);
}

// Nine pillars of heights and friction of their own, and a rough object of 0.2 kg.
RoughContact rough(double one_side_friction = 1) {
  const auto layout = TaxelLayout::grid(3, 3, 0.007);
  RoughContactSettings settings;
  settings.height_sigma_m = 30e-6;
  settings.texture = {.rms_m = 20e-6, .shortest_m = 0.006, .longest_m = 0.02};
  settings.one_side_friction = one_side_friction;
  return {settings, layout.x_m(), layout.y_m(), layout.area_m2(), kSeed};
}

TEST(RoughContacts, CarryTheForcesGivenAndNoMoreThanFrictionHolds) {
  RoughContact contact = rough();
  for (int i = 1; i <= 400; ++i) {
    contact.press(2 + std::sin(0.1 * i), 0.5);
    const bool slid = contact.sliding();
    contact.pull(0.9 * std::sin(0.037 * i), kStep_s);
    const double normal_n = 2 + std::sin(0.1 * i);
    ASSERT_NEAR(sum_of(contact.normal_n()), normal_n, 1e-9);
    ASSERT_NEAR(contact.capacity_n(), 0.5 * normal_n, 1e-9);
    ASSERT_NEAR(sum_of(contact.shear_n()), contact.carried_n(), 1e-9);
    if (!slid && std::fabs(0.9 * std::sin(0.037 * i)) < contact.capacity_n()) {
      ASSERT_NEAR(contact.carried_n(), 0.9 * std::sin(0.037 * i), 1e-9);
    }
    for (std::size_t k = 0; k < 9; ++k)
      ASSERT_LE(std::fabs(contact.shear_n()[k]), 0.5 * contact.normal_n()[k] + 1e-12);
  }
}

TEST(RoughContacts, LetSomePillarsSlipBeforeTheObjectSlides) {
  RoughContact contact = rough();
  contact.press(2, 0.5);
  std::vector<std::size_t> slipping;
  for (const double load : {0.3, 0.6, 0.9, 0.99}) {
    contact.pull(load * contact.capacity_n(), kStep_s);
    EXPECT_NEAR(contact.safety_margin(), 1 - load, 1e-9);
    std::size_t count = 0, pressed = 0;
    for (std::size_t k = 0; k < 9; ++k) {
      pressed += contact.normal_n()[k] > 0 ? 1 : 0;
      count += contact.normal_n()[k] > 0 && contact.shear_n()[k] > 0.4999 * contact.normal_n()[k] ? 1 : 0;
    }
    EXPECT_LT(count, pressed) << load;
    slipping.push_back(count);
  }
  EXPECT_TRUE(std::is_sorted(slipping.begin(), slipping.end()));
  EXPECT_GT(slipping.back(), slipping.front());
}

TEST(RoughContacts, SlideAsABodyOfTheirMassAndStopByFriction) {
  RoughContact contact = rough();
  contact.press(2, 0.5);
  for (int ms = 1; ms <= 50; ++ms) {
    contact.pull(1.2, kStep_s);
    EXPECT_EQ(contact.safety_margin(), 0);
  }
  // 0.2 N too much on 0.2 kg for 50 ms, and as long again to stop.
  EXPECT_NEAR(contact.slid_m(), 0.5 * 1 * 0.05 * 0.05, 5e-5);
  EXPECT_TRUE(contact.sliding());
  for (int ms = 1; ms <= 52; ++ms) contact.pull(0.8, kStep_s);
  EXPECT_FALSE(contact.sliding());
  EXPECT_NEAR(contact.slid_m(), 1 * 0.05 * 0.05, 1e-4);
  EXPECT_NEAR(contact.carried_n(), 0.8, 1e-9);
}

// Half of the sum of changes in p/P.
double moved_share(std::span<const double> now, const std::vector<double>& then, double normal_n) {
  double sum = 0;
  for (std::size_t i = 0; i < then.size(); ++i) sum += std::fabs(now[i] - then[i]) / normal_n / 2;
  return sum;
}

TEST(RoughContacts, MoveTheReliefOverTheTaxelsWhileTheySlideAndOnlyThen) {
  RoughContact contact = rough();
  contact.press(2, 0.5);
  const std::vector<double> held(contact.normal_n().begin(), contact.normal_n().end());
  for (int ms = 0; ms < 1000; ++ms) {
    contact.press(2, 0.5);
    contact.pull(0.9 * std::sin(0.01 * ms), kStep_s);
  }
  EXPECT_NEAR(moved_share(contact.normal_n(), held, 2), 0, 1e-9);
  for (int ms = 0; ms < 100; ++ms) {
    contact.press(2, 0.5);
    contact.pull(1.2, kStep_s);
  }
  EXPECT_GT(std::fabs(contact.slid_m()), 0.004);
  EXPECT_GT(moved_share(contact.normal_n(), held, 2), 0.1);
}

TEST(RoughContacts, OfOneSlipperySideHoldLess) {
  RoughContact contact = rough(0.5);
  contact.press(3, 0.6);
  EXPECT_LT(contact.capacity_n(), 0.6 * 3);
  EXPECT_GT(contact.capacity_n(), 0.3 * 3);
  EXPECT_NEAR(contact.friction(), contact.capacity_n() / 3, 1e-12);
}

TEST(RoughContacts, BeginAnewElsewhereOnTheObject) {
  RoughContact contact = rough();
  contact.press(2, 0.5);
  contact.pull(1.5, kStep_s);
  const std::vector<double> first(contact.normal_n().begin(), contact.normal_n().end());
  contact.press(0, 0.5);
  EXPECT_TRUE(std::isnan(contact.safety_margin()));
  EXPECT_EQ(sum_of(contact.shear_n()), 0);
  contact.press(2, 0.5);
  EXPECT_EQ(contact.safety_margin(), 1);
  EXPECT_FALSE(contact.sliding());
  EXPECT_GT(moved_share(contact.normal_n(), first, 2), 0.05);
}

TEST(Presets, HaveNamesAndEffects) {
  for (const Preset preset : {Preset::ideal, Preset::pillars, Preset::magnetic_skin}) {
    EXPECT_EQ(preset_of(to_string(preset)), preset);
    EXPECT_EQ(effects_of(preset).has_value(), preset != Preset::ideal);
  }
  EXPECT_EQ(preset_of("velvet"), std::nullopt);
}

}  // namespace
}  // namespace slipd::sim
