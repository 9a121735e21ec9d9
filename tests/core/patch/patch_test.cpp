#include "core/patch/patch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

using synthetic::FrameMaker;
using synthetic::Noise;

TEST(PatchFinder, FindsForcesPlaceAndRadiusOfAContactAnywhereOnThePad) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  FrameMaker maker(TaxelLayout::grid(100, 100, 0.00016));
  PatchFinder finder(maker.layout());
  for (int i = 0; i < 50; ++i) {
    contact::LoadHistory contact(synthetic::random_pair(random));
    const double normal = 0.5 + 4 * unit(random), friction = 0.2 + 0.6 * unit(random);
    contact.move_to(normal, 0, friction);
    contact.move_to(normal, 0.7 * friction * normal, friction);
    const double x = 0.001 * (2 * unit(random) - 1), y = 0.001 * (2 * unit(random) - 1),
                 toward = 6.28 * unit(random);
    const auto& patch = finder.find(maker.make(contact, x, y, toward, 0.02));
    ASSERT_TRUE(patch.in_contact);
    EXPECT_NEAR(patch.normal_n / normal, 1, 0.005);
    EXPECT_NEAR(patch.shear_n / contact.shear_n(), 1, 0.005);
    EXPECT_NEAR(patch.center_x_m, x, 2e-5);
    EXPECT_NEAR(patch.center_y_m, y, 2e-5);
    EXPECT_NEAR(patch.radius_m / contact.contact_radius_m(), 1, 0.01);
    EXPECT_NEAR(patch.direction_x, std::cos(toward), 0.01);
    EXPECT_NEAR(patch.direction_y, std::sin(toward), 0.01);
  }
}

TEST(PatchFinder, MeasuresTheNoiseInsteadOfAssumingIt) {
  FrameMaker maker(TaxelLayout::grid(100, 100, 0.00016));
  PatchFinder finder(maker.layout());
  contact::LoadHistory contact(synthetic::paper_pair());
  contact.move_to(2, 0, 0.5);
  contact.move_to(2, 0.6, 0.5);
  for (const double noise : {0.01, 0.05, 0.1}) {
    const auto& patch = finder.find(maker.make(contact, 0, 0, 0, noise, Noise::sensor));
    // Uniform noise of half-width w has the standard deviation w / sqrt(3). The frame's maximum is the
    // pressure at the centre.
    const double want = noise * synthetic::paper_pair().peak_pressure_pa(2) / std::sqrt(3.0);
    EXPECT_NEAR(patch.noise_normal_pa / want, 1, 0.05);
    EXPECT_NEAR(patch.noise_shear_pa / want, 1, 0.05);
  }
}

TEST(PatchFinder, NoiseAloneIsNoContact) {
  const auto layout = TaxelLayout::grid(64, 64, 0.00025);
  PatchFinder finder(layout);
  std::mt19937_64 random(12);
  std::normal_distribution<float> noise(0, 500);
  std::vector<float> p(layout.size()), x(layout.size()), y(layout.size());
  for (int i = 0; i < 200; ++i) {
    for (auto* channel : {&p, &x, &y}) {
      for (auto& value : *channel) value = noise(random);
    }
    EXPECT_FALSE(finder.find({1, 1, p, x, y}).in_contact);
  }
  std::fill(p.begin(), p.end(), 0.0F);
  EXPECT_FALSE(finder.find({1, 1, p, x, y}).in_contact);
}

TEST(PatchFinder, DetectsAContactThatTheEdgeCuts) {
  FrameMaker maker(TaxelLayout::grid(50, 50, 0.0003));
  PatchFinder finder(maker.layout());
  contact::LoadHistory contact(synthetic::paper_pair());
  contact.move_to(2, 0.5, 0.5);
  EXPECT_FALSE(finder.find(maker.make(contact, 0.002, 0, 0, 0.01)).cut);
  EXPECT_TRUE(finder.find(maker.make(contact, 0.0065, 0, 0, 0.01)).cut);
}

// A contact of 2 N in the middle of the pad; the chosen taxels read nothing.
class Blinded {
 public:
  Blinded() {
    contact_.move_to(2, 0, 0.5);
    contact_.move_to(2, 0.6, 0.5);
  }
  template <typename Chosen>
  Frame frame(Chosen dead) {
    const Frame sensed = maker_.make(contact_, 0, 0, 0.3, 0.01, Noise::sensor);
    p_.assign(sensed.normal_pa.begin(), sensed.normal_pa.end());
    x_.assign(sensed.shear_x_pa.begin(), sensed.shear_x_pa.end());
    y_.assign(sensed.shear_y_pa.begin(), sensed.shear_y_pa.end());
    for (std::size_t i = 0; i < p_.size(); ++i)
      if (dead(i)) p_[i] = x_[i] = y_[i] = 0;
    return {sensed.sequence, sensed.time_ns, p_, x_, y_};
  }
  double from_middle_m(std::size_t i) const {
    return std::hypot(maker_.layout().x_m()[i], maker_.layout().y_m()[i]);
  }
  double radius_m() const { return contact_.contact_radius_m(); }
  const TaxelLayout& layout() const { return maker_.layout(); }

 private:
  contact::LoadHistory contact_{synthetic::paper_pair()};
  FrameMaker maker_{TaxelLayout::grid(32, 32, 0.0005)};
  std::vector<float> p_, x_, y_;
};

TEST(PatchFinder, NeighboursStandForDeadTaxels) {
  Blinded blinded;
  PatchFinder finder(blinded.layout());
  EXPECT_EQ(finder.find(blinded.frame([](std::size_t) { return false; })).interpolated, 0U);
  std::mt19937 random(4);
  std::bernoulli_distribution dead(0.05);
  for (int i = 0; i < 20; ++i) {
    const auto& patch = finder.find(blinded.frame([&](std::size_t) { return dead(random); }));
    EXPECT_GT(patch.interpolated, 0U);
    EXPECT_NEAR(patch.normal_n / 2, 1, 0.02);
    EXPECT_NEAR(patch.shear_n / 0.6, 1, 0.03);
    EXPECT_NEAR(patch.radius_m / blinded.radius_m(), 1, 0.01);
    EXPECT_NEAR(patch.center_x_m, 0, 5e-5);
  }
}

// Interpolation adds no pressure outside a contact nor in a pit within it.
TEST(PatchFinder, InterpolationFillsNoPitInAContact) {
  Blinded blinded;
  PatchFinder finder(blinded.layout());
  const auto& patch = finder.find(
      blinded.frame([&](std::size_t i) { return blinded.from_middle_m(i) < 0.4 * blinded.radius_m(); }));
  ASSERT_TRUE(patch.in_contact);
  const double outside_n = 2 * std::pow(1 - 0.4 * 0.4, 1.5);
  EXPECT_NEAR(patch.normal_n / outside_n, 1, 0.1);
}

TEST(PatchFinder, NeighboursStandForDeadTaxelsAlsoWhereThereIsNoGrid) {
  const auto grid = TaxelLayout::grid(32, 32, 0.0005);
  const auto layout =
      TaxelLayout::scattered({grid.x_m().begin(), grid.x_m().end()}, {grid.y_m().begin(), grid.y_m().end()});
  Blinded blinded;
  PatchFinder scattered(layout), regular(grid);
  const Frame frame = blinded.frame([](std::size_t i) { return i % 37 == 0; });
  const auto& patch = scattered.find(frame);
  EXPECT_GT(patch.interpolated, 0U);
  EXPECT_NEAR(patch.normal_n, regular.find(frame).normal_n, 1e-6);
}

}  // namespace
}  // namespace slipd
