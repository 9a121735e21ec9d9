#include "core/reading/fit/fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "core/numeric/iteration.hpp"
#include "tests/support/heap_count.hpp"
#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

using synthetic::FrameMaker;
using synthetic::Noise;
constexpr Range kPossibleFriction{0.1, 0.9};

struct Result {
  double error = 0, right = 0, within_one = 0, within_two = 0, safer = 0, answered = 0;
};

// Contacts drawn as in docs/methods.md §26.1, up to 2 mm off the middle of a +-8 mm pad, Gamma uniform, exact
// averages.
Result try_contacts(std::size_t side, double noise, Noise kind, int contacts,
                    const FitOptions& options = {}) {
  std::mt19937_64 random(31);
  std::uniform_real_distribution<double> unit(0, 1);
  FrameMaker maker(TaxelLayout::grid(side, side, 0.016 / static_cast<double>(side)));
  PatchFinder finder(maker.layout());
  const auto fit = make_fit(maker.layout(), kPossibleFriction, {}, options);
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
    const Reading reading = fit->estimate(frame, patch);
    if (!reading.in_model) continue;
    const double error = std::fabs(reading.gamma - gamma);
    result.answered += 1;
    result.error += error;
    result.right += slip_class(reading.gamma) == slip_class(gamma) ? 1 : 0;
    result.within_one += error < reading.sigma ? 1 : 0;
    result.within_two += error < 2 * reading.sigma ? 1 : 0;
    result.safer += reading.gamma - gamma > 0.2 ? 1 : 0;
  }
  for (double* value : {&result.error, &result.right, &result.within_one, &result.within_two, &result.safer})
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
  TaxelFit fit(maker.layout(), kPossibleFriction);
  contact::LoadHistory contact(synthetic::paper_pair());
  contact.move_to(2, 0, 0.5);
  contact.move_to(2, 0.6, 0.5);
  const Frame frame = maker.make(contact, 0.0060, 0, 0.3, 0.01);
  const auto& patch = finder.find(frame);
  ASSERT_TRUE(patch.cut);
  const Reading reading = fit.estimate(frame, patch);
  ASSERT_TRUE(reading.in_model);
  EXPECT_NEAR(reading.gamma, 0.4, std::max(0.01, 3 * reading.sigma));
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Single frames of 4 x 4 taxels leave the margin open, and yet show where and how wide the contact is.
TEST(Fit, OfFewTaxelsFindsPlaceAndRadiusBetterThanTheirSums) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  FrameMaker maker(TaxelLayout::grid(4, 4, 0.0047));
  PatchFinder finder(maker.layout());
  FewTaxelsFit fit(maker.layout(), kPossibleFriction);
  std::vector<double> fitted_m, summed_m, radius_m, summed_radius_m;
  constexpr std::size_t kContacts = 200;
  for (std::size_t i = 0; i < kContacts; ++i) {
    contact::LoadHistory contact(synthetic::random_pair(random));
    contact.move_to(4, 0, 0.5);
    contact.move_to(4, 1, 0.5);
    const double x = 0.003 * (2 * unit(random) - 1), y = 0.003 * (2 * unit(random) - 1);
    const Frame frame = maker.make(contact, x, y, 6.28 * unit(random), 0.01, Noise::sensor);
    const auto& patch = finder.find(frame);
    const Reading reading = fit.estimate(frame, patch);
    if (!reading.in_model) continue;
    fitted_m.push_back(std::hypot(reading.center_x_m - x, reading.center_y_m - y));
    summed_m.push_back(std::hypot(patch.center_x_m - x, patch.center_y_m - y));
    radius_m.push_back(std::fabs(reading.radius_m - contact.contact_radius_m()));
    summed_radius_m.push_back(std::fabs(patch.radius_m - contact.contact_radius_m()));
  }
  ASSERT_GT(fitted_m.size(), 9 * kContacts / 10);
  EXPECT_LT(median(fitted_m), 0.8 * median(summed_m));
  EXPECT_LT(median(radius_m), 0.5 * median(summed_radius_m));
}

// Noise puts the likeliest margin of a light pull on few taxels at 0 or 1 half of the time.
TEST(Fit, ConvergesInAFewStepsAlsoWhereTheLikeliestMarginIsAtABound) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> unit(0, 1);
  FrameMaker maker(TaxelLayout::grid(4, 4, 0.004));
  PatchFinder finder(maker.layout());
  FewTaxelsFit fit(maker.layout(), kPossibleFriction);
  constexpr int kContacts = 400;
  int converged = 0, steps = 0;
  for (int i = 0; i < kContacts; ++i) {
    contact::LoadHistory contact(synthetic::random_pair(random));
    contact.move_to(3, 0, 0.5);
    contact.move_to(3, 1.5 * unit(random), 0.5);
    const double x = 0.002 * (2 * unit(random) - 1), y = 0.002 * (2 * unit(random) - 1);
    const Frame frame = maker.make(contact, x, y, 6.28 * unit(random), 0.02, Noise::sensor);
    converged += fit.estimate(frame, finder.find(frame)).in_model ? 1 : 0;
    steps += fit.steps();
  }
  EXPECT_GT(converged, 0.9 * kContacts);
  EXPECT_LT(steps, 7 * kContacts);
}

// Corners that taxels share and corners of each taxel round differently. Contacts within a single taxel show
// nothing of their place, and rounding must not decide what is read of them.
TEST(Fit, ReadsAGridAsItReadsTheSameTaxelsAtAnyPlaces) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> unit(0, 1);
  const TaxelLayout grid = TaxelLayout::grid(4, 4, 0.006);
  FrameMaker maker(grid);
  PatchFinder finder(grid);
  const auto of_grid = make_fit(grid, kPossibleFriction);
  const auto scattered = make_fit(
      TaxelLayout::scattered({grid.x_m().begin(), grid.x_m().end()}, {grid.y_m().begin(), grid.y_m().end()}),
      kPossibleFriction);
  int compared = 0, within_one = 0;
  constexpr int kContacts = 200;
  for (int i = 0; i < kContacts; ++i) {
    contact::LoadHistory contact(synthetic::random_pair(random));
    const double normal_n = 0.3 + 3 * unit(random);
    contact.move_to(normal_n, 0, 0.5);
    contact.move_to(normal_n, 0.5 * unit(random) * normal_n, 0.5);
    const double x = 0.006 * (2 * unit(random) - 1), y = 0.006 * (2 * unit(random) - 1);
    const Frame frame = maker.make(contact, x, y, 6.28 * unit(random), 0.01, Noise::sensor);
    const ContactPatch& patch = finder.find(frame);
    const Reading one = of_grid->estimate(frame, patch), other = scattered->estimate(frame, patch);
    EXPECT_EQ(one.in_model, other.in_model);
    if (!one.in_model) continue;
    ++compared;
    const double to_edge =
        std::min(std::fabs(std::fmod(std::fabs(x), 0.006)), std::fabs(std::fmod(std::fabs(y), 0.006)));
    within_one += contact.contact_radius_m() < to_edge ? 1 : 0;
    EXPECT_NEAR(one.gamma, other.gamma, 0.01);
    EXPECT_NEAR(one.sigma, other.sigma, 0.01);
    EXPECT_NEAR(one.radius_m, other.radius_m, 0.1 * one.radius_m);
  }
  EXPECT_GT(compared, 0.9 * kContacts);
  EXPECT_GT(within_one, 5);
}

TEST(Fit, OtherHistoriesAreNotInTheModelButGrossSlipIsDetected) {
  FrameMaker maker(TaxelLayout::grid(100, 100, 0.000144));
  PatchFinder finder(maker.layout());
  TaxelFit fit(maker.layout(), kPossibleFriction);
  contact::LoadHistory contact(synthetic::paper_pair());
  contact.move_to(2, 0, 0.5);
  contact.move_to(2, 0.8, 0.5);
  contact.move_to(3, 0.8, 0.5);
  const Frame regripped = maker.make(contact, 0, 0, 0.3, 0.01);
  EXPECT_FALSE(fit.estimate(regripped, finder.find(regripped)).in_model);
  contact.move_to(3, -0.9, 0.5);
  contact.move_to(3, 0.6, 0.5);
  const Frame reversed = maker.make(contact, 0, 0, 0.3, 0.01);
  const Reading reading = fit.estimate(reversed, finder.find(reversed));
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

// Of pulls from nothing to 1 N, `step_n` apart; nor more steps than that.
void expect_no_allocation(Fit& fit, FrameMaker& maker, double step_n, int most_steps) {
  PatchFinder finder(maker.layout());
  contact::LoadHistory contact(synthetic::paper_pair());
  contact.move_to(2, 0, 0.5);
  for (double shear_n = 0.001; shear_n < 1; shear_n += step_n) {
    contact.move_to(2, shear_n, 0.5);
    const Frame frame = maker.make(contact, 0, 0, 0.3, 0.05, Noise::sensor);
    const auto before = test::allocations();
    fit.estimate(frame, finder.find(frame));
    EXPECT_EQ(test::allocations(), before);
    EXPECT_LE(fit.steps(), most_steps);
  }
}

TEST(Fit, AllocatesNothingAndTakesABoundedNumberOfSteps) {
  FrameMaker maker(TaxelLayout::grid(32, 32, 0.0005));
  TaxelFit fit(maker.layout(), kPossibleFriction);
  expect_no_allocation(fit, maker, 0.05, kMostSteps);
}

// The bounds are 1.5 times the Gaussian Cramér–Rao bound of all taxels, in brackets, and what so few contacts
// scatter.
TEST(BlockFit, ComesNearTheLimitOfAllTaxelsWithACorrectSigma) {
  struct Case {
    double noise;
    Noise kind;
    double most_error;
  };
  constexpr int kContacts = 200;
  for (const auto& c : {Case{0.05, Noise::relative, 0.0014},   // [0.0008]
                        Case{0.01, Noise::sensor, 0.0021},     // [0.0012]
                        Case{0.05, Noise::sensor, 0.0095}}) {  // [0.0054]
    SCOPED_TRACE(std::to_string(c.noise) + (c.kind == Noise::sensor ? " sensor" : " relative"));
    const Result got = try_contacts(100, c.noise, c.kind, kContacts, FitOptions::in_blocks());
    EXPECT_GT(got.answered, 0.98);
    EXPECT_LT(got.error, c.most_error);
    EXPECT_LT(got.safer, 0.01);
    const auto scatter = [&](double share) { return 2 * std::sqrt(share * (1 - share) / kContacts); };
    EXPECT_NEAR(got.within_one, 0.68, 0.05 + scatter(0.68));
    EXPECT_NEAR(got.within_two, 0.95, 0.03 + scatter(0.95));
  }
}

double by_noise(const Reading& of) {
  return std::sqrt(of.sigma * of.sigma - of.common_sigma * of.common_sigma);
}

// Grids whose taxels are no whole number of blocks, contacts at their edges and beyond them, and dead taxels.
TEST(BlockFit, AgreesWithTheFitOfAllTaxelsWithinSigma) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const bool dead : {false, true}) {
    FrameMaker maker(TaxelLayout::grid(97, 71, 0.000144));
    PatchFinder finder(maker.layout());
    TaxelFit fit(maker.layout(), kPossibleFriction);
    BlockFit in_blocks(maker.layout(), kPossibleFriction);
    std::vector<float> normal, x, y;
    int answered = 0, beyond = 0;
    constexpr int kContacts = 60;
    for (int i = 0; i < kContacts; ++i) {
      contact::LoadHistory contact(synthetic::random_pair(random));
      const double force = 2 + 3 * unit(random), friction = 0.3 + 0.6 * unit(random);
      contact.move_to(force, 0, friction);
      contact.move_to(force, (0.1 + 0.7 * unit(random)) * friction * force, friction);
      const Frame made = maker.make(contact, 0.006 * (2 * unit(random) - 1), 0.004 * (2 * unit(random) - 1),
                                    6.28 * unit(random), 0.01, Noise::sensor);
      normal.assign(made.normal_pa.begin(), made.normal_pa.end());
      x.assign(made.shear_x_pa.begin(), made.shear_x_pa.end());
      y.assign(made.shear_y_pa.begin(), made.shear_y_pa.end());
      for (std::size_t taxel = 11; dead && taxel < normal.size(); taxel += 211)
        normal[taxel] = x[taxel] = y[taxel] = 0;
      const Frame frame{made.sequence, made.time_ns, normal, x, y};
      const ContactPatch& patch = finder.find(frame);
      ASSERT_TRUE(patch.in_contact);
      const Reading all = fit.estimate(frame, patch), few = in_blocks.estimate(frame, patch);
      if (!all.in_model || !few.in_model) continue;
      ++answered;
      // Of a contact that is cut the disc is a guess, beyond which blocks reach farther than taxels do.
      if (!patch.cut) {
        EXPECT_GT(by_noise(few), 0.9 * by_noise(all)) << "there is no more to know in blocks";
      }
      // Of the difference, at most: blocks know what taxels know and less.
      if (std::fabs(few.gamma - all.gamma) > 2 * few.sigma) ++beyond;
      EXPECT_NEAR(few.gamma, all.gamma, 4 * few.sigma);
      EXPECT_NEAR(few.radius_m, all.radius_m, 0.02 * all.radius_m);
    }
    EXPECT_GT(answered, 0.9 * kContacts);
    EXPECT_LT(beyond, 0.05 * kContacts + 2);
  }
}

TEST(BlockFit, OtherHistoriesAreNotInTheModel) {
  FrameMaker maker(TaxelLayout::grid(100, 100, 0.000144));
  PatchFinder finder(maker.layout());
  BlockFit fit(maker.layout(), kPossibleFriction);
  contact::LoadHistory contact(synthetic::paper_pair());
  contact.move_to(2, 0, 0.5);
  contact.move_to(2, 0.8, 0.5);
  const Frame risen = maker.make(contact, 0, 0, 0.3, 0.01);
  EXPECT_TRUE(fit.estimate(risen, finder.find(risen)).in_model);
  contact.move_to(3, 0.8, 0.5);
  const Frame regripped = maker.make(contact, 0, 0, 0.3, 0.01);
  EXPECT_FALSE(fit.estimate(regripped, finder.find(regripped)).in_model);
  contact.move_to(3, -0.9, 0.5);
  contact.move_to(3, 0.6, 0.5);
  const Frame reversed = maker.make(contact, 0, 0, 0.3, 0.01);
  EXPECT_FALSE(fit.estimate(reversed, finder.find(reversed)).in_model);
}

TEST(BlockFit, IsTheFitOfSingleTaxelsWhereTheyAreInNoGridOrFew) {
  const TaxelLayout grid = TaxelLayout::grid(30, 30, 0.0003);
  const TaxelLayout scattered =
      TaxelLayout::scattered({grid.x_m().begin(), grid.x_m().end()}, {grid.y_m().begin(), grid.y_m().end()});
  const auto in_blocks = [](const TaxelLayout& layout) {
    return make_fit(layout, kPossibleFriction, {}, FitOptions::in_blocks());
  };
  EXPECT_EQ(in_blocks(grid)->name(), Method::block_fit);
  EXPECT_EQ(in_blocks(TaxelLayout::grid(6, 6, 0.001))->name(), Method::fit);
  FrameMaker maker(scattered);
  PatchFinder finder(scattered);
  TaxelFit fit(scattered, kPossibleFriction);
  const auto wanted_in_blocks = in_blocks(scattered);
  EXPECT_EQ(wanted_in_blocks->name(), Method::fit);
  contact::LoadHistory contact(synthetic::paper_pair());
  contact.move_to(2, 0, 0.5);
  contact.move_to(2, 0.6, 0.5);
  const Frame frame = maker.make(contact, 0, 0, 0.3, 0.01);
  const ContactPatch& patch = finder.find(frame);
  EXPECT_EQ(wanted_in_blocks->estimate(frame, patch).gamma, fit.estimate(frame, patch).gamma);
}

TEST(BlockFit, AllocatesNothing) {
  FrameMaker maker(TaxelLayout::grid(80, 80, 0.0002));
  BlockFit fit(maker.layout(), kPossibleFriction);
  expect_no_allocation(fit, maker, 0.1, 2 * kMostSteps);
}

}  // namespace
}  // namespace slipd
