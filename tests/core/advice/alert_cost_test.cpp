// What a slip that is not told costs, and how much of sigma is taken off the margin for it.
#include <gtest/gtest.h>

#include <random>
#include <utility>
#include <vector>

#include "core/advice/alert.hpp"

namespace slipd {
namespace {

// Margins whose errors are drawn: what is taken off at a cost is what costs least in the mean, of all that
// could be taken off.
TEST(AlertCost, ChoosesTheAlertThatCostsLeast) {
  constexpr double kThreshold = 0.4, kSigma = 0.1;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> truths(-0.6, 1.4);
  std::normal_distribution<double> errors(0, kSigma);
  std::vector<std::pair<double, double>> margins;  // true, estimated
  for (int i = 0; i < 200'000; ++i) {
    const double truth = truths(random);
    margins.emplace_back(truth, truth + errors(random));
  }
  for (const double cost : {1.0, 5.0, 20.0, 100.0}) {
    const auto paid = [&](double sigmas) {
      double sum = 0;
      for (const auto& [truth, seen] : margins) {
        const bool alert = seen - sigmas * kSigma < kThreshold, due = truth < kThreshold;
        if (alert != due) sum += due ? cost : 1;
      }
      return sum;
    };
    const double chosen = sigmas_for(cost);
    EXPECT_LT(paid(chosen), paid(chosen - 0.3)) << cost;
    EXPECT_LT(paid(chosen), paid(chosen + 0.3)) << cost;
  }
}

TEST(AlertCost, AndSigmasSayTheSame) {
  EXPECT_NEAR(sigmas_for(1), 0, 1e-12);
  for (const double sigmas : {0.0, 0.5, 1.0, 3.0, 10.0})
    EXPECT_NEAR(sigmas_for(cost_of(sigmas)), sigmas, 1e-9);
}

}  // namespace
}  // namespace slipd
