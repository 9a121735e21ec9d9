#include "paper/validation/tradeoff.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/chain/chain.hpp"
#include "core/chain/setup/method_table.hpp"
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
  TaxelFit fit(layout, {0.1, 0.9});
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

}  // namespace
}  // namespace slipd
