// What `auto` chooses: by the size of contacts and by the time that a frame may take, the same at each start.
#include "core/chain/setup/method_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/chain/chain.hpp"
#include "core/contact/scene_draws.hpp"

namespace slipd {
namespace {

Scene paper_scene() {
  Scene scene;
  scene.objects = paper_objects();
  scene.offset_m = 0.002;
  scene.noise = 0.01;
  return scene;
}

// A pad of 16 mm of side x side taxels, on the scene of the paper.
ChainSetup pad_of(std::size_t side, double depth_m = 0) {
  ChainSetup setup{.layout = TaxelLayout::grid(side, side, 0.016 / static_cast<double>(side)),
                   .scene = paper_scene(),
                   .estimator = {},
                   .alerts = {},
                   .friction = {}};
  setup.scene.skin.depth_m = depth_m;
  return setup;
}

AutoChoice choice_of(const ChainSetup& setup) {
  return choose_for(setup, expected_work(setup));
}

TEST(MethodTable, HasEachMethodInAscendingSizesWithErrorsAndTimes) {
  for (const MethodTableRow& row : method_table()) {
    EXPECT_GT(row.mean_error, 0);
    EXPECT_LT(row.mean_error, 0.35) << "a margin drawn at random is a third off";
    EXPECT_GT(row.answered, 0);
    EXPECT_LE(row.answered, 1);
    EXPECT_GT(row.p50_us, 0);
    EXPECT_GE(row.p99_us, row.p50_us);
  }
  for (std::size_t i = 1; i < method_table().size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const MethodTableRow &one = method_table()[k], &other = method_table()[i];
      if (one.method != other.method || one.under_skin != other.under_skin) continue;
      EXPECT_LT(one.taxels_along_radius, other.taxels_along_radius);
    }
  }
}

// The method of a pad of 16 x 16 whose contacts are so many taxels in radius.
TradeoffRow fit_at(double taxels_along_radius) {
  ChainSetup setup = pad_of(16);
  setup.layout = TaxelLayout::grid(16, 16, mean_contact_radius_m(setup.scene) / taxels_along_radius);
  return expected_work(setup).rows.back();
}

TEST(MethodTable, IsLinearInTaxelsBetweenSizesAndTheLastRowBeyond) {
  const MethodTableRow* before = nullptr;
  for (const MethodTableRow& row : method_table()) {
    if (row.method != Method::fit || row.under_skin) continue;
    const double at = row.taxels_along_radius;
    EXPECT_NEAR(fit_at(at).p50_us, row.p50_us, 1e-6 * row.p50_us);
    if (before != nullptr) {
      const double square = at * at + before->taxels_along_radius * before->taxels_along_radius;
      const double middle_us = (row.p50_us + before->p50_us) / 2;
      EXPECT_NEAR(fit_at(std::sqrt(square / 2)).p50_us, middle_us, 1e-6 * middle_us);
    }
    before = &row;
  }
  ASSERT_NE(before, nullptr);
  EXPECT_EQ(fit_at(1000).p50_us, before->p50_us);
}

TEST(MethodTable, TheChoiceIsTheLeastErrorWithinTheBudgetOrTheFastest) {
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

TEST(MethodTable, BlocksPayWhereContactsAreManyTaxelsWideOnAGrid) {
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

TEST(MethodTable, AutoTakesWhatIsMostAccurateWithinTheBudget) {
  for (const std::size_t side : {8, 16, 32, 64, 100}) {
    ChainSetup setup = pad_of(side);
    const WorkPrecision work = expected_work(setup);
    ASSERT_EQ(work.rows.size(), side >= 64 ? 3U : 2U);
    double fastest_us = std::numeric_limits<double>::infinity();
    for (const TradeoffRow& row : work.rows) fastest_us = std::min(fastest_us, row.p50_us);
    for (const double budget_us : {0.1, 5.0, 20.0, 50.0, 200.0, 1e6}) {
      setup.estimator.budget_us = budget_us;
      const EstimatorChain chain(setup, nullptr);
      const auto chosen =
          std::ranges::find(work.rows, std::string(to_string(chain.method())), &TradeoffRow::method);
      ASSERT_NE(chosen, work.rows.end());
      EXPECT_LE(chosen->p50_us, std::max(budget_us, fastest_us)) << side << ", " << budget_us;
      for (const TradeoffRow& row : work.rows) {
        if (row.p50_us > budget_us || row.answered != chosen->answered) continue;
        EXPECT_LE(chosen->mean_error, row.mean_error) << side << ", " << budget_us;
      }
    }
    setup.estimator.budget_us = 1e6;
    EXPECT_NE(EstimatorChain(setup, nullptr).method(), Method::moments) << side;
  }
}

TEST(MethodTable, TheSameSceneHasTheSameMethodAtEachStart) {
  for (const std::size_t side : {7, 12, 25, 50, 100}) {
    for (const double depth_m : {0.0, 0.001}) {
      const ChainSetup setup = pad_of(side, depth_m);
      const Method first = EstimatorChain(setup, nullptr).method();
      for (int start = 0; start < 3; ++start) EXPECT_EQ(EstimatorChain(setup, nullptr).method(), first);
    }
  }
}

TEST(MethodTable, WithoutABudgetThereAre100MicrosecondsAtTheSurfaceAndNoLimitUnderASkin) {
  ChainSetup setup = pad_of(16);
  EXPECT_EQ(frame_budget_us(setup), 100);
  setup.scene.skin.depth_m = 0.001;
  EXPECT_EQ(frame_budget_us(setup), std::numeric_limits<double>::infinity());
  setup.scene.skin.depth_m = 1e-6;
  EXPECT_EQ(frame_budget_us(setup), 100) << "too thin to be sensed";
  setup.scene.skin.depth_m = 0.001;
  setup.estimator.budget_us = 300;
  EXPECT_EQ(frame_budget_us(setup), 300);
}

TEST(MethodTable, ABudgetIsObeyedUnderASkinToo) {
  ChainSetup setup = pad_of(16, 0.001);
  const WorkPrecision work = expected_work(setup);
  ASSERT_EQ(work.rows.size(), 2U);
  EXPECT_EQ(work.rows[0].method, "fit");
  EXPECT_EQ(work.rows[1].method, "closing");
  const double fit_us = work.rows[0].p50_us, closing_us = work.rows[1].p50_us;
  EXPECT_EQ(choice_of(setup).method, Method::fit);
  EXPECT_TRUE(choice_of(setup).closing_beside);
  setup.estimator.budget_us = fit_us + closing_us;
  EXPECT_EQ(choice_of(setup).method, Method::fit);
  EXPECT_TRUE(choice_of(setup).closing_beside);
  setup.estimator.budget_us = fit_us + closing_us - 1;
  EXPECT_FALSE(choice_of(setup).closing_beside) << "both together take too long";
  const double least_us = std::min(fit_us, closing_us);
  for (const double budget_us : {1.0, least_us}) {
    setup.estimator.budget_us = budget_us;
    EXPECT_EQ(choice_of(setup).method, fit_us < closing_us ? Method::fit : Method::closing);
    EXPECT_FALSE(choice_of(setup).closing_beside);
    EXPECT_EQ(EstimatorChain(setup, nullptr).method(), choice_of(setup).method);
  }
}

TEST(MethodTable, PressureMapsAreNoChoiceWhereTheyCannotReadTheLayout) {
  ChainSetup setup = pad_of(16, 0.001);
  setup.scene.skin.base = SkinBase::rigid;
  setup.estimator.budget_us = 1;
  EXPECT_EQ(expected_work(setup).rows.size(), 1U);
  EXPECT_EQ(choice_of(setup).method, Method::fit);
  EXPECT_FALSE(choice_of(setup).closing_beside);
}

}  // namespace
}  // namespace slipd
