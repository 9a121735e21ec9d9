#include "paper/train.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "paper/model/model_file.hpp"

namespace slipd {
namespace {

ModelSetup setup_of_side(std::size_t side) {
  Scene scene;
  scene.objects = paper_objects();
  scene.noise = 0.01;
  return {TaxelLayout::grid(side, side, 0.0144 / static_cast<double>(side)),
          scene,
          {.contacts = 60, .loads = 10},
          1,
          8,
          5};
}

TEST(Training, DoesNotDependOnTheNumberOfThreads) {
  EXPECT_EQ(encode_model(train(setup_of_side(16), 1)), encode_model(train(setup_of_side(16), 3)));
}

TEST(Training, ProgressRisesToOne) {
  double last = 0;
  train(setup_of_side(16), 2, [&](double share, const char*) {
    EXPECT_GE(share, last - 1e-12);
    last = share;
  });
  EXPECT_EQ(last, 1);
}

TEST(Training, ExplainedVarianceRisesWithTheBasesAndStaysBelowOne) {
  const Model model(train(setup_of_side(16)));
  for (std::size_t bases = 1; bases <= model.rank(); ++bases)
    EXPECT_GT(model.explained(bases), model.explained(bases - 1));
  EXPECT_GT(model.explained(8), 0.9);
  EXPECT_LE(model.explained(8), 1);
}

TEST(Training, AModelAtALowerRankIsTheFirstBasesOfTheHigherOne) {
  const auto models = train_ranks(setup_of_side(16), {8, 3});
  ASSERT_EQ(models.size(), 2U);
  EXPECT_EQ(models[1].setup.rank, 3);
  for (std::size_t row = 0; row < 256; ++row) {
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(models[1].basis[3 * row + k], models[0].basis[8 * row + k]);
  }
  EXPECT_GT(models[1].errors.residual_limit, models[0].errors.residual_limit);
  EXPECT_EQ(Model(models[1]).rank(), 3U);
}

TEST(Training, AScatteredLayoutWithFewerTaxelsThanBasesWorks) {
  ModelSetup setup = setup_of_side(16);
  setup.layout = TaxelLayout::scattered({0, 2e-3, 0, 2e-3, 1e-3}, {0, 0, 2e-3, 2e-3, 1e-3});
  EXPECT_EQ(Model(train(setup)).rank(), 5U);
}

TEST(Training, ScenesWithoutAUsableContactAreRefused) {
  ModelSetup single = setup_of_side(16);
  single.layout = TaxelLayout::wrench(0.02);
  EXPECT_THROW(train(single), ModelError);

  ModelSetup beside = setup_of_side(16);
  beside.layout = TaxelLayout::scattered({1, 1.001, 1}, {1, 1, 1.001});  // a metre away from all contacts
  EXPECT_THROW(train(beside), ModelError);

  ModelSetup flat = setup_of_side(16);
  flat.scene.skin.radius_m = std::numeric_limits<double>::infinity();
  for (auto& family : flat.scene.objects) family.flat_share = 1;
  EXPECT_THROW(train(flat), std::invalid_argument);
}

}  // namespace
}  // namespace slipd
