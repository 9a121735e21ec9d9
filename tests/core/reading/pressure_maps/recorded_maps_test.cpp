// The maps of a closing, and what is expected of friction where a pull is faint.
#include "core/reading/pressure_maps/recorded_maps.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/reading/method/friction_prior.hpp"

namespace slipd {
namespace {

constexpr std::size_t kTaxels = 6, kPressed = 4;

// Pressures that are parabolas over the root of the force; the last taxels are beside the contact.
std::vector<float> parabolas(double normal_n) {
  const double root = std::sqrt(normal_n);
  std::vector<float> out(kTaxels, 0);
  for (std::size_t i = 0; i < kPressed; ++i)
    out[i] = static_cast<float>(1e3 * (static_cast<double>(i + 1) * root + 0.7 * normal_n));
  return out;
}

RecordedMaps closed(float beside_pa = 0) {
  RecordedMaps maps(kTaxels);
  for (int i = 0; i < 20; ++i) {
    const double normal_n = std::pow(0.1 * i + 0.05, 2);  // each has a map of its own
    std::vector<float> pressure = parabolas(normal_n);
    pressure.back() = beside_pa;
    maps.add({pressure.data(), nullptr, nullptr}, normal_n);
  }
  maps.find_contact(10);
  return maps;
}

TEST(RecordedMaps, FindParabolasOverTheRootOfTheForceBetweenThem) {
  const RecordedMaps maps = closed();
  ASSERT_EQ(maps.size(), 20U);
  for (const double normal_n : {0.001, 0.03, 0.33, 1.234, 3.5, 3.8, 3.9}) {
    const RecordedMaps::Sum sum = maps.at(normal_n);
    const std::vector<float> expected = parabolas(normal_n);
    for (std::size_t taxel = 0; taxel < kTaxels; ++taxel) {
      double value = 0;
      for (std::size_t i = 0; i < RecordedMaps::Sum::kTerms; ++i)
        value += sum.weight[i] * maps.values(sum.map[i], RecordedMaps::normal)[taxel];
      EXPECT_NEAR(value, expected[taxel], 1) << normal_n << " N, taxel " << taxel;
    }
  }
}

TEST(RecordedMaps, SumOverTheContactAlone) {
  const RecordedMaps quiet = closed(), noisy = closed(25);
  EXPECT_EQ(quiet.contact().size(), kPressed);
  EXPECT_EQ(noisy.contact().size(), kPressed);
  const RecordedMaps::Sum slipping = RecordedMaps::difference(noisy.at(4), noisy.at(1));
  double expected = 0;
  const std::vector<float> all = parabolas(4), stuck = parabolas(1);
  for (std::size_t i = 0; i < kTaxels; ++i) expected += std::pow(all[i] - stuck[i], 2);
  EXPECT_NEAR(noisy.square_pa2(slipping, 0), expected, 1e-3 * expected);
  EXPECT_NEAR(quiet.square_pa2(slipping, 0), noisy.square_pa2(slipping, 0), 1e-9 * expected);
}

// Against the least of both costs by brute force.
TEST(FrictionPrior, WeighsAMeasurementWithWhatIsExpected) {
  const FrictionPrior prior{.expected = {0.3, 1.0}};
  for (const double measured : {-0.1, 0.01, 0.15, 0.28, 0.5, 1.05, 1.3}) {
    for (const double sigma : {0.003, 0.03, 0.3}) {
      const double information = 1 / (sigma * sigma);
      const auto cost = [&](double mu) {
        const double off = mu - measured, below = std::min(measured, 0.0);
        return 0.5 * information * (off * off - below * below) + prior.nats_against(mu);
      };
      double least = cost(1);
      for (double mu = 0.001; mu < 2; mu += 0.001) least = std::min(least, cost(mu));
      const FrictionPrior::Weighed weighed = prior.weigh(measured, information);
      EXPECT_GT(weighed.mu, 0);
      EXPECT_GE(weighed.mu, std::min(measured, 0.3));
      EXPECT_LE(weighed.mu, std::max(measured, 1.0));
      // Both costs are taken for parabolas; the prior's is one over the logarithm. Beyond some nats it is
      // only said that the measurement does not fit.
      if (least < 10)
        EXPECT_NEAR(weighed.nats, least, 0.05 + 0.35 * least) << measured << " +- " << sigma;
      else
        EXPECT_GT(weighed.nats, 10) << measured << " +- " << sigma;
    }
  }
}

TEST(FrictionPrior, LeavesAMeasurementWithinTheRangeAsItIs) {
  const FrictionPrior prior{.expected = {0.3, 1.0}};
  const FrictionPrior::Weighed weighed = prior.weigh(0.6, 100);
  EXPECT_EQ(weighed.mu, 0.6);
  EXPECT_EQ(weighed.nats, 0);
}

}  // namespace
}  // namespace slipd
