#include "core/reading/moments/moments.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

using synthetic::FrameMaker;

TEST(Moments, TheRatioIsInvertedFromNoLoadToGrossSlip) {
  for (double k = 0.001; k < 1; k += 0.01) {
    const double ratio = (1 - std::pow(k, 5)) / (1 - k * k * k);
    EXPECT_NEAR(gamma_of_moment_ratio(ratio), k * k * k, 1e-9);
  }
  EXPECT_EQ(gamma_of_moment_ratio(0.9), 0);
  EXPECT_EQ(gamma_of_moment_ratio(2), 1);
}

// New contacts, up to 2 mm off the middle of a +-8 mm pad, Gamma uniform: mean error and calibration of
// sigma.
TEST(Moments, ReadUnseenContactsOffTheMiddleWithAnHonestSigma) {
  std::mt19937_64 random(21);
  std::uniform_real_distribution<double> unit(0, 1);
  FrameMaker maker(TaxelLayout::grid(100, 100, 0.00016));
  PatchFinder finder(maker.layout());
  Moments moments(maker.layout());
  double error = 0;
  int within_two = 0, answered = 0;
  constexpr int kContacts = 200;
  for (int i = 0; i < kContacts; ++i) {
    contact::LoadHistory contact(synthetic::random_pair(random));
    const double normal = 1 + 4 * unit(random), friction = 0.1 + 0.8 * unit(random), gamma = unit(random);
    contact.move_to(normal, 0, friction);
    contact.move_to(normal, (1 - gamma) * friction * normal, friction);
    const Frame frame = maker.make(contact, 0.002 * (2 * unit(random) - 1), 0.002 * (2 * unit(random) - 1),
                                   6.28 * unit(random), 0.05);
    const auto& patch = finder.find(frame);
    if (patch.cut) continue;  // the largest contacts reach beyond the edge
    const Reading reading = moments.estimate(frame, patch);
    ASSERT_TRUE(reading.in_model) << "gamma " << gamma << " friction " << friction;
    ++answered;
    error += std::fabs(reading.gamma - gamma);
    within_two += std::fabs(reading.gamma - gamma) < 2 * reading.sigma ? 1 : 0;
  }
  EXPECT_GT(answered, 0.95 * kContacts);
  EXPECT_LT(error / answered, 0.006);  // 0.003 measured
  EXPECT_GT(within_two, 0.95 * answered);
}

TEST(Moments, OtherHistoriesAreNotOfTheFamily) {
  FrameMaker maker(TaxelLayout::grid(100, 100, 0.000144));
  PatchFinder finder(maker.layout());
  Moments moments(maker.layout());
  const auto in_model = [&](const contact::LoadHistory& contact) {
    const Frame frame = maker.make(contact, 0, 0, 0.5, 0.01);
    return moments.estimate(frame, finder.find(frame)).in_model;
  };
  contact::LoadHistory contact(synthetic::paper_pair());
  contact.move_to(2, 0, 0.5);
  contact.move_to(2, 0.8, 0.5);
  EXPECT_TRUE(in_model(contact));
  contact::LoadHistory regripped = contact, reversed = contact;
  regripped.move_to(3, 0.8, 0.5);
  EXPECT_FALSE(in_model(regripped));
  reversed.move_to(2, 0.2, 0.5);
  EXPECT_FALSE(in_model(reversed));
}

}  // namespace
}  // namespace slipd
