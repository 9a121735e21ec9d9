#include "tools/slipctl/tally.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/tools/samples.hpp"

namespace slipctl::testing {
namespace {

using ::testing::HasSubstr;

EstimateView reading(std::uint64_t sequence, const std::string& alert, double gamma = 0.5) {
  nlohmann::json sample = estimate_sample("left", sequence, gamma);
  sample["alert"] = alert;
  return reading_from(sample);
}

nlohmann::json totals(const Tally& tally) {
  return tally.json(counts_from(status_sample({"left"}, 100)), counts_from(status_sample({"left"}, 1100)),
                    2)["sensors"][0];
}

TEST(Tally, CountsEachRiseOfTheAlertOnce) {
  Tally tally;
  std::uint64_t sequence = 0;
  for (const char* alert : {"none", "warn", "warn", "slip", "slip", "warn", "none", "slip", "none"})
    tally.take(reading(++sequence, alert), true);
  EXPECT_EQ(totals(tally)["warnings"], 1);
  EXPECT_EQ(totals(tally)["slips"], 2);
  EXPECT_TRUE(tally.slip_seen());
}

TEST(Tally, CountsAnEventAndItsEstimateOnceInWhicheverOrderTheyCome) {
  for (const bool event_first : {true, false}) {
    Tally tally;
    tally.take(reading(1, "none"), true);
    tally.take(reading(2, "slip"), !event_first);
    tally.take(reading(2, "slip"), event_first);
    EXPECT_EQ(totals(tally)["slips"], 1);
    EXPECT_EQ(totals(tally)["seen"], 2);
  }
}

TEST(Tally, SeesNoSlipWhereThereIsNone) {
  Tally tally;
  tally.take(reading(1, "warn"), true);
  EXPECT_FALSE(tally.slip_seen());
}

TEST(Tally, MeasuresTheMarginsAgainstTheTruth) {
  Tally tally;
  for (int i = 0; i < 10; ++i) {
    EstimateView each = reading(static_cast<std::uint64_t>(i), "none", 0.5);
    each.true_gamma = 0.5 + 0.01 * i;
    tally.take(each, true);
  }
  EXPECT_NEAR(totals(tally)["mean_error"].get<double>(), 0.045, 1e-12);
  EXPECT_NEAR(totals(tally)["worst_error"].get<double>(), 0.09, 1e-12);
}

TEST(Tally, ClaimsNoErrorWithoutATruth) {
  Tally tally;
  EstimateView real = reading(1, "none");
  real.true_gamma.reset();
  tally.take(real, true);
  EXPECT_TRUE(totals(tally)["mean_error"].is_null());
}

TEST(Tally, TellsTheDaemonsCountsOfTheTimeItLooked) {
  Tally tally;
  tally.take(reading(1, "none"), true);
  EXPECT_THAT(
      tally.text(counts_from(status_sample({"left"}, 100)), counts_from(status_sample({"left"}, 1100)), 2),
      HasSubstr("left: 1000 frames in 2.0 s (500 Hz), 1000 estimated, 0 skipped, 0 gaps"));
}

}  // namespace
}  // namespace slipctl::testing
