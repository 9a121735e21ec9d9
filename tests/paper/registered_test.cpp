// The estimator on rings in the contact's own frame, which does not depend on position, size, stiffness and
// force.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "paper/dataset/ring_columns.hpp"
#include "paper/method/svd_knn.hpp"
#include "paper/model_setup.hpp"
#include "paper/train.hpp"
#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

// New contacts, up to 2 mm off the middle of a +-8 mm pad, relative noise of 5 %, Gamma uniform, three
// bases.
TEST(Registered, ReadsUnseenContactsWhereverTheyLie) {
  Scene scene;
  scene.objects = paper_objects();
  scene.noise = 0.05;
  scene.offset_m = 0.002;
  const auto layout = TaxelLayout::grid(64, 64, 0.016 / 64);
  const auto model = std::make_shared<const Model>(train({.layout = layout,
                                                          .scene = scene,
                                                          .size = {.contacts = 320, .loads = 50},
                                                          .rank = 3,
                                                          .view = View::rings}));
  EXPECT_EQ(model->data().basis.size(), Rings::kCount * 3);
  SvdKnn registered(model);
  EXPECT_EQ(registered.name(), Method::registered);

  synthetic::FrameMaker maker(layout, 5);
  PatchFinder finder(layout);
  std::mt19937_64 random(51);
  std::uniform_real_distribution<double> unit(0, 1);
  int answered = 0, within_two = 0;
  double error = 0;
  constexpr int kContacts = 300;
  for (int i = 0; i < kContacts; ++i) {
    contact::LoadHistory contact(synthetic::random_pair(random));
    const double normal = 1 + 4 * unit(random), friction = 0.1 + 0.8 * unit(random), gamma = unit(random);
    contact.move_to(normal, 0, friction);
    contact.move_to(normal, (1 - gamma) * friction * normal, friction);
    const Frame frame = maker.make(contact, 0.002 * (2 * unit(random) - 1), 0.002 * (2 * unit(random) - 1),
                                   2 * std::numbers::pi * unit(random), 0.05);
    const Reading reading = registered.estimate(frame, finder.find(frame));
    if (!reading.in_model) continue;
    ++answered;
    error += std::fabs(reading.gamma - gamma);
    within_two += std::fabs(reading.gamma - gamma) < 2 * reading.sigma ? 1 : 0;
  }
  EXPECT_GT(answered, 0.9 * kContacts);
  EXPECT_LT(error / answered, 0.015);
  EXPECT_GT(within_two, 0.85 * answered);
  RecordProperty("mean_error", std::to_string(error / answered));
}

TEST(Registered, FewTaxelsAreReadOnFewRings) {
  const auto rings_of = [](std::size_t side) {
    ChainSetup chain{.layout = TaxelLayout::grid(side, side, 0.016 / static_cast<double>(side)),
                     .scene = {},
                     .estimator = {},
                     .alerts = {},
                     .friction = {}};
    chain.scene.objects = paper_objects();
    chain.estimator.method = MethodChoice::registered;
    return model_setup_of(chain).rings;
  };
  EXPECT_EQ(rings_of(100), 16);
  EXPECT_EQ(rings_of(16), 8);
  EXPECT_EQ(rings_of(8), 4);
}

TEST(Registered, MergedRingsCarryTheSameForces) {
  Rings rings;
  for (std::size_t j = 0; j < Rings::kCount; ++j) {
    rings.normal_n[j] = static_cast<double>(j);
    rings.shear_n[j] = 1;
    rings.taxels[j] = 2;
  }
  const Rings four = merged(rings, 4);
  EXPECT_EQ(four.normal_n[0], 0 + 1 + 2 + 3);
  EXPECT_EQ(four.normal_n[3], 12 + 13 + 14 + 15);
  EXPECT_EQ(four.shear_n[1], 4);
  EXPECT_EQ(four.taxels[2], 8);
  EXPECT_EQ(four.taxels[4], 0);
}

TEST(Registered, OnFourRingsInDoublePrecisionItAnswersAsInSingle) {
  Scene scene;
  scene.objects = paper_objects();
  const auto layout = TaxelLayout::grid(32, 32, 0.0005);
  ModelSetup setup{.layout = layout,
                   .scene = scene,
                   .size = {.contacts = 60, .loads = 20},
                   .rank = 3,
                   .view = View::rings};
  setup.rings = 4;
  const auto model = std::make_shared<const Model>(train(setup));
  EXPECT_EQ(model->data().basis.size(), 4U * 3U);
  SvdKnn single(model), twice(model, Precision::double_precision);
  EXPECT_EQ(single.settings().rings, 4);
  EXPECT_EQ(single.settings().rank, 3);
  contact::LoadHistory contact(synthetic::paper_pair());
  contact.move_to(2, 0, 0.5);
  contact.move_to(2, 0.6, 0.5);
  synthetic::FrameMaker maker(layout, 3);
  PatchFinder finder(layout);
  const Frame frame = maker.make(contact, 0, 0, 0.3, 0.001);
  const auto& patch = finder.find(frame);
  const Reading one = single.estimate(frame, patch), two = twice.estimate(frame, patch);
  ASSERT_TRUE(one.in_model);
  EXPECT_NEAR(one.gamma, 0.4, 0.05);
  EXPECT_NEAR(one.gamma, two.gamma, 1e-4);
}

}  // namespace
}  // namespace slipd
