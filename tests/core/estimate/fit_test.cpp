#include "core/estimate/fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/heap_count.hpp"
#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

using synthetic::FrameMaker;
using synthetic::Noise;
constexpr Range kFriction{0.1, 0.9};

struct Result {
  double error = 0, right = 0, within_one = 0, within_two = 0, answered = 0;
};

// Contacts drawn as in docs/theory.md §9.1, up to 2 mm off the middle of a +-8 mm pad, Gamma uniform, exact
// averages.
Result try_contacts(std::size_t side, double noise, Noise kind, int contacts) {
  std::mt19937_64 random(31);
  std::uniform_real_distribution<double> unit(0, 1);
  FrameMaker maker(TaxelLayout::grid(side, side, 0.016 / static_cast<double>(side)));
  PatchFinder finder(maker.layout());
  Fit fit(maker.layout(), kFriction);
  Result result;
  for (int i = 0; i < contacts; ++i) {
    contact::LoadHistory contact(synthetic::random_pair(random));
    const double normal = 1 + 4 * unit(random), friction = 0.1 + 0.8 * unit(random), gamma = unit(random);
    contact.move_to(normal, 0, friction);
    contact.move_to(normal, (1 - gamma) * friction * normal, friction);
    const Frame frame = maker.make(contact, 0.002 * (2 * unit(random) - 1), 0.002 * (2 * unit(random) - 1),
                                   6.28 * unit(random), noise, kind);
    const auto& patch = finder.find(frame);
    if (!patch.in_contact) continue;
    const FrameEstimate reading = fit.estimate(frame, patch);
    if (!reading.in_model) continue;
    const double error = std::fabs(reading.gamma - gamma);
    result.answered += 1;
    result.error += error;
    result.right += slip_class(reading.gamma) == slip_class(gamma) ? 1 : 0;
    result.within_one += error < reading.sigma ? 1 : 0;
    result.within_two += error < 2 * reading.sigma ? 1 : 0;
  }
  for (double* value : {&result.error, &result.right, &result.within_one, &result.within_two})
    *value /= result.answered;
  result.answered /= contacts;
  return result;
}

// The bounds are this project's goals; in brackets the Gaussian Cramér–Rao bound, for comparison.
TEST(Fit, ComesNearTheLimitOnEachLayoutWithACorrectSigma) {
  struct Case {
    std::size_t side;
    double noise;
    Noise kind;
    double most_error, least_right;
    int contacts;
  };
  for (const auto& c : {Case{100, 0.05, Noise::relative, 0.0013, 0.994, 200},   // [0.0008; 99.8 %]
                        Case{32, 0.01, Noise::relative, 0.0013, 0.993, 600},    // [0.0008; 99.6 %]
                        Case{16, 0.01, Noise::relative, 0.004, 0.983, 800},     // [0.0024; 99.2 %]
                        Case{16, 0.01, Noise::sensor, 0.03, 0.90, 800},         // [0.023; 94.2 %]
                        Case{8, 0.01, Noise::relative, 0.012, 0.955, 1500}}) {  // [0.0076; 97.4 %]
    SCOPED_TRACE(std::to_string(c.side) + " x " + std::to_string(c.side));
    const Result got = try_contacts(c.side, c.noise, c.kind, c.contacts);
    EXPECT_GT(got.answered, 0.95);
    EXPECT_LT(got.error, c.most_error);
    // Tolerance: two standard deviations of a share of so few contacts.
    const auto scatter = [&](double share) { return 2 * std::sqrt(share * (1 - share) / c.contacts); };
    EXPECT_GE(got.right, c.least_right - scatter(c.least_right));
    EXPECT_NEAR(got.within_one, 0.68, 0.05 + scatter(0.68));
    EXPECT_NEAR(got.within_two, 0.95, 0.05 + scatter(0.95));
  }
}

TEST(Fit, ReadsAContactThatTheEdgeCutsFromItsVisiblePart) {
  FrameMaker maker(TaxelLayout::grid(50, 50, 0.0003));
  PatchFinder finder(maker.layout());
  Fit fit(maker.layout(), kFriction);
  contact::LoadHistory contact(synthetic::paper_pair());
  contact.move_to(2, 0, 0.5);
  contact.move_to(2, 0.6, 0.5);
  const Frame frame = maker.make(contact, 0.0060, 0, 0.3, 0.01);
  const auto& patch = finder.find(frame);
  ASSERT_TRUE(patch.cut);
  const FrameEstimate reading = fit.estimate(frame, patch);
  ASSERT_TRUE(reading.in_model);
  EXPECT_NEAR(reading.gamma, 0.4, std::max(0.01, 3 * reading.sigma));
}

TEST(Fit, OtherHistoriesAreNotInTheModelButGrossSlipIsDetected) {
  FrameMaker maker(TaxelLayout::grid(100, 100, 0.000144));
  PatchFinder finder(maker.layout());
  Fit fit(maker.layout(), kFriction);
  contact::LoadHistory contact(synthetic::paper_pair());
  contact.move_to(2, 0, 0.5);
  contact.move_to(2, 0.8, 0.5);
  contact.move_to(3, 0.8, 0.5);
  const Frame regripped = maker.make(contact, 0, 0, 0.3, 0.01);
  EXPECT_FALSE(fit.estimate(regripped, finder.find(regripped)).in_model);
  contact.move_to(3, -0.9, 0.5);
  contact.move_to(3, 0.6, 0.5);
  const Frame reversed = maker.make(contact, 0, 0, 0.3, 0.01);
  const FrameEstimate reading = fit.estimate(reversed, finder.find(reversed));
  EXPECT_FALSE(reading.in_model);
  double q = 0, q2 = 0;  // of the discs of the exact history
  for (const auto& term : contact.shear_terms()) {
    const double force = term.coefficient * std::pow(term.radius_m, 3);
    q += force;
    q2 += force * std::pow(term.radius_m / contact.contact_radius_m(), 2);
  }
  const double slip_moment_n = (5.0 / 3 - q2 / q) * contact.shear_n();
  EXPECT_NEAR(reading.moments.slip_moment_n, slip_moment_n, 3 * reading.moments_sigma.slip_moment_n);
  EXPECT_LT(reading.moments_sigma.slip_moment_n, 0.02 * slip_moment_n);
}

TEST(Fit, AllocatesNothingAndTakesABoundedNumberOfSteps) {
  FrameMaker maker(TaxelLayout::grid(32, 32, 0.0005));
  PatchFinder finder(maker.layout());
  Fit fit(maker.layout(), kFriction);
  contact::LoadHistory contact(synthetic::paper_pair());
  contact.move_to(2, 0, 0.5);
  for (double shear = 0.001; shear < 1; shear += 0.05) {
    contact.move_to(2, shear, 0.5);
    const Frame frame = maker.make(contact, 0, 0, 0.3, 0.05, Noise::sensor);
    const auto before = test::allocations();
    fit.estimate(frame, finder.find(frame));
    EXPECT_EQ(test::allocations(), before);
    EXPECT_LE(fit.steps(), Fit::kMostSteps);
  }
}

}  // namespace
}  // namespace slipd
