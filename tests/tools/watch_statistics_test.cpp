#include "tools/slipctl/watch_statistics.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/tools/samples.hpp"

namespace slipctl::testing {
namespace {

using ::testing::HasSubstr;

EstimateValues estimate(std::uint64_t sequence, const std::string& alert, double gamma = 0.5) {
  nlohmann::json sample = estimate_sample("left", sequence, gamma);
  sample["alert"] = alert;
  return estimate_from(sample);
}

nlohmann::json totals(const WatchStatistics& statistics) {
  return statistics.json(counts_from(status_sample({"left"}, 100)),
                         counts_from(status_sample({"left"}, 1100)), 2)["sensors"][0];
}

TEST(WatchStatistics, CountsEachRiseOfTheAlertOnce) {
  WatchStatistics statistics;
  std::uint64_t sequence = 0;
  for (const char* alert : {"none", "warn", "warn", "slip", "slip", "warn", "none", "slip", "none"})
    statistics.take(estimate(++sequence, alert), true);
  EXPECT_EQ(totals(statistics)["warnings"], 1);
  EXPECT_EQ(totals(statistics)["slips"], 2);
  EXPECT_TRUE(statistics.slip_seen());
}

TEST(WatchStatistics, CountsAnEventAndItsEstimateOnceInWhicheverOrderTheyCome) {
  for (const bool event_first : {true, false}) {
    WatchStatistics statistics;
    statistics.take(estimate(1, "none"), true);
    statistics.take(estimate(2, "slip"), !event_first);
    statistics.take(estimate(2, "slip"), event_first);
    EXPECT_EQ(totals(statistics)["slips"], 1);
    EXPECT_EQ(totals(statistics)["seen"], 2);
  }
}

TEST(WatchStatistics, CountsNoSlipWithoutOne) {
  WatchStatistics statistics;
  statistics.take(estimate(1, "warn"), true);
  EXPECT_FALSE(statistics.slip_seen());
}

TEST(WatchStatistics, MeasuresTheMarginsAgainstTheTruth) {
  WatchStatistics statistics;
  for (int i = 0; i < 10; ++i) {
    EstimateValues each = estimate(static_cast<std::uint64_t>(i), "none", 0.5);
    each.true_gamma = 0.5 + 0.01 * i;
    statistics.take(each, true);
  }
  EXPECT_NEAR(totals(statistics)["mean_error"].get<double>(), 0.045, 1e-12);
  EXPECT_NEAR(totals(statistics)["worst_error"].get<double>(), 0.09, 1e-12);
}

TEST(WatchStatistics, ClaimsNoErrorWithoutATruth) {
  WatchStatistics statistics;
  EstimateValues real = estimate(1, "none");
  real.true_gamma.reset();
  statistics.take(real, true);
  EXPECT_TRUE(totals(statistics)["mean_error"].is_null());
}

TEST(WatchStatistics, HasTheDaemonsCountsOfItsTime) {
  WatchStatistics statistics;
  statistics.take(estimate(1, "none"), true);
  EXPECT_THAT(statistics.text(counts_from(status_sample({"left"}, 100)),
                              counts_from(status_sample({"left"}, 1100)), 2),
              HasSubstr("left: 1000 frames in 2.0 s (500 Hz), 1000 estimated, 0 skipped, 0 gaps"));
}

}  // namespace
}  // namespace slipctl::testing
