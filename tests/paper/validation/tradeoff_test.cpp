#include "paper/validation/tradeoff.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/chain/chain.hpp"
#include "core/chain/method_table.hpp"
#include "core/reading/fit/fit.hpp"
#include "core/reading/moments/moments.hpp"
#include "paper/train.hpp"

namespace slipd {
namespace {

Scene paper_scene() {
  Scene scene;
  scene.objects = paper_objects();
  scene.offset_m = 0.002;
  scene.noise = 0.01;
  return scene;
}

TEST(Tradeoff, ShowsThatFitIsSlowerAndMoreAccurate) {
  const auto layout = TaxelLayout::grid(16, 16, 0.001);
  Moments moments(layout);
  Fit fit(layout, {0.1, 0.9});
  const auto cheap = measure_tradeoff(layout, paper_scene(), moments, NoiseKind::relative, 0.01, 200, 7);
  const auto dear = measure_tradeoff(layout, paper_scene(), fit, NoiseKind::relative, 0.01, 200, 7);
  EXPECT_LT(dear.mean_error, 0.5 * cheap.mean_error);
  EXPECT_GT(dear.p50_us, cheap.p50_us);
  EXPECT_GT(dear.answered, 0.95);
}

TEST(Tradeoff, TheSameSeedGivesTheSameErrors) {
  const auto layout = TaxelLayout::grid(16, 16, 0.001);
  Moments moments(layout);
  const auto once = measure_tradeoff(layout, paper_scene(), moments, NoiseKind::sensor, 0.02, 50, 3);
  const auto again = measure_tradeoff(layout, paper_scene(), moments, NoiseKind::sensor, 0.02, 50, 3);
  EXPECT_EQ(once.mean_error, again.mean_error);
  EXPECT_EQ(once.p95_error, again.p95_error);
}

TEST(Tradeoff, AModelHasTheErrorOfEachMethodAndRank) {
  const ModelSetup setup{.layout = TaxelLayout::grid(16, 16, 0.001),
                         .scene = paper_scene(),
                         .size = {.contacts = 60, .loads = 20},
                         .view = View::rings};
  std::vector<std::shared_ptr<const Model>> models;
  for (auto& data : train_ranks(setup, {5, 3}))
    models.push_back(std::make_shared<const Model>(std::move(data)));
  const WorkPrecision work_precision = measure_work_precision(models, 30, 9);
  ASSERT_EQ(work_precision.rows.size(), 5U);
  EXPECT_FALSE(work_precision.processor.empty());
  EXPECT_EQ(work_precision.rows[0].method, "moments");
  EXPECT_EQ(work_precision.rows[1].method, "fit");
  EXPECT_EQ(work_precision.rows[2].settings.rank, 5);
  EXPECT_EQ(work_precision.rows[3].settings.rank, 3);
  EXPECT_EQ(work_precision.rows[3].settings.rings, 16);
  EXPECT_EQ(work_precision.rows[4].settings.precision, Precision::double_precision);
  EXPECT_NEAR(work_precision.rows[4].mean_error, work_precision.rows[2].mean_error, 1e-3);
  EXPECT_GT(work_precision.rows[2].settings.memory_bytes, work_precision.rows[3].settings.memory_bytes);
  EXPECT_GT(work_precision.rows[1].settings.memory_bytes, work_precision.rows[0].settings.memory_bytes);
}

TEST(Tradeoff, TheChoiceIsTheLeastErrorWithinTheBudgetOrTheFastest) {
  TradeoffRow quick, good, mute;
  quick.mean_error = 0.02;
  quick.p50_us = 5;
  good.mean_error = 0.002;
  good.p50_us = 80;
  mute.mean_error = 0.001;
  mute.p50_us = 60;
  quick.answered = good.answered = 1;
  mute.answered = 0.2;
  const TradeoffRow rows[] = {quick, good, mute};
  EXPECT_EQ(choose(rows, 100), 1U);
  EXPECT_EQ(choose(rows, 50), 0U);
  EXPECT_EQ(choose(rows, 1), 0U);
}

TEST(Tradeoff, BlocksPayWhereContactsAreManyTaxelsWideOnAGrid) {
  const Scene scene = paper_scene();
  const auto pad = [](std::size_t side) {
    return TaxelLayout::grid(side, side, 0.016 / static_cast<double>(side));
  };
  EXPECT_TRUE(blocks_pay(pad(100), scene));
  EXPECT_TRUE(blocks_pay(pad(64), scene));
  EXPECT_FALSE(blocks_pay(pad(32), scene));
  EXPECT_FALSE(blocks_pay(TaxelLayout::grid(6, 6, 0.0001), scene)) << "few taxels";
  const TaxelLayout fine = TaxelLayout::grid(20, 20, 0.00016);
  EXPECT_FALSE(blocks_pay(
      TaxelLayout::scattered({fine.x_m().begin(), fine.x_m().end()}, {fine.y_m().begin(), fine.y_m().end()}),
      scene));
}

TEST(Tradeoff, AutoMeasuresBlockFitBetweenMomentsAndFitWhereBlocksPay) {
  const auto layout = TaxelLayout::grid(64, 64, 0.00025);
  ChainSetup setup{.layout = layout, .scene = paper_scene(), .estimator = {}, .alerts = {}, .friction = {}};
  for (const double budget_us : {1.0, 1e6}) {
    setup.estimator.budget_us = budget_us;
    const EstimatorChain chain(setup, nullptr);
    const auto& rows = chain.tradeoff().rows;
    ASSERT_EQ(rows.size(), 3U);
    EXPECT_EQ(rows[0].method, "moments");
    EXPECT_EQ(rows[1].method, "block-fit");
    EXPECT_EQ(rows[2].method, "fit");
    EXPECT_LT(rows[1].mean_error, rows[0].mean_error);
    EXPECT_EQ(to_string(chain.method()), rows[choose(rows, budget_us)].method);
  }
  setup.estimator.method = MethodChoice::block_fit;
  EXPECT_EQ(EstimatorChain(setup, nullptr).method(), Method::block_fit);
  const WorkPrecision alone = measure_work_precision(setup, Method::block_fit);
  ASSERT_EQ(alone.rows.size(), 1U);
  EXPECT_EQ(alone.rows[0].method, "block-fit");
}

}  // namespace
}  // namespace slipd
