// The kinds of sensors, and what each kind's chain is made of: nothing that it does not need.
#include "core/chain/setup/sensor_kind.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "core/chain/chain.hpp"

namespace slipd {
namespace {

using ::testing::ElementsAre;

ChainSetup setup_of(std::size_t side, SensorClass sensor_class = SensorClass::array3) {
  ChainSetup setup{.layout = TaxelLayout::grid(side, side, 0.0144 / static_cast<double>(side)),
                   .sensor_class = sensor_class,
                   .scene = {},
                   .estimator = {.method = MethodChoice::fit},
                   .alerts = {},
                   .friction = {}};
  setup.scene.objects = paper_objects();
  return setup;
}

ChainSetup flat(ChainSetup setup) {
  setup.scene.skin.radius_m = std::numeric_limits<double>::infinity();
  return setup;
}

ChainSetup of_pillars(ChainSetup setup) {
  setup.scene.skin.base = SkinBase::pillars;
  return setup;
}

ChainSetup under_skin(ChainSetup setup) {
  setup.scene.skin.depth_m = 1e-3;
  return setup;
}

ChainSetup with_friction(ChainSetup setup) {
  setup.friction = KnownFriction(0.5);
  return setup;
}

std::vector<std::string_view> stages_of(const ChainSetup& setup) {
  return EstimatorChain(setup, nullptr).stages();
}

TEST(SensorKind, FollowsFromClassTaxelsAndSkin) {
  EXPECT_EQ(kind_of(setup_of(16, SensorClass::normal)), SensorKind::pressure_only);
  EXPECT_EQ(kind_of(flat(setup_of(16, SensorClass::normal))), SensorKind::pressure_only);
  EXPECT_EQ(kind_of(setup_of(1, SensorClass::wrench)), SensorKind::one_force);
  EXPECT_EQ(kind_of(setup_of(1)), SensorKind::one_force);
  EXPECT_EQ(kind_of(flat(setup_of(1))), SensorKind::one_force);
  EXPECT_EQ(kind_of(flat(setup_of(4))), SensorKind::flat_pad);
  EXPECT_EQ(kind_of(flat(setup_of(16))), SensorKind::flat_pad);
  EXPECT_EQ(kind_of(of_pillars(setup_of(4))), SensorKind::pillars);
  EXPECT_EQ(kind_of(of_pillars(flat(setup_of(4)))), SensorKind::pillars)
      << "a curved pad of them or a flat one";
  EXPECT_EQ(kind_of(of_pillars(setup_of(1))), SensorKind::one_force);
  EXPECT_EQ(kind_of(setup_of(4)), SensorKind::few_taxels);
  EXPECT_EQ(kind_of(setup_of(16)), SensorKind::array);
}

TEST(SensorKind, ASkinCountsOnlyForAContactModelAndFromANinthOfATaxelOn) {
  EXPECT_EQ(sensed_depth_m(under_skin(setup_of(16))), 1e-3);
  EXPECT_EQ(sensed_depth_m(under_skin(flat(setup_of(16)))), 0);
  ChainSetup thin = setup_of(16);
  thin.scene.skin.depth_m = thin.layout.side_m() / 10;
  EXPECT_EQ(sensed_depth_m(thin), 0);
}

TEST(Chains, ConstructTheStagesOfTheirKindAndNoOthers) {
  EXPECT_THAT(stages_of(setup_of(16, SensorClass::normal)),
              ElementsAre("contact_patch", "health", "contact_gate", "taxel_pattern"));
  EXPECT_THAT(
      stages_of(setup_of(1, SensorClass::wrench)),
      ElementsAre("contact_patch", "health", "contact_gate", "equivalent_pull", "friction_by_forces"));
  EXPECT_THAT(stages_of(flat(setup_of(4))),
              ElementsAre("contact_patch", "health", "contact_gate", "equivalent_pull", "pad_load_sharing",
                          "friction_by_forces", "taxel_pattern"));
  EXPECT_THAT(stages_of(of_pillars(setup_of(4))),
              ElementsAre("contact_patch", "health", "contact_gate", "equivalent_pull", "friction_by_pillars",
                          "taxel_pattern"));
  EXPECT_THAT(stages_of(flat(setup_of(16))),
              ElementsAre("contact_patch", "health", "contact_gate", "equivalent_pull", "friction_by_forces",
                          "taxel_pattern"))
      << "taxels of a large pad are no contacts of their own";
  EXPECT_THAT(stages_of(setup_of(4)),
              ElementsAre("contact_patch", "health", "contact_gate", "equivalent_pull", "fit",
                          "forces_at_surface", "friction_by_forces", "taxel_pattern"));
  EXPECT_THAT(stages_of(setup_of(16)),
              ElementsAre("contact_patch", "health", "contact_gate", "equivalent_pull", "fit",
                          "torque_reading", "forces_at_surface", "friction_by_shape", "taxel_pattern"));
}

TEST(Chains, ConstructWhatTheSettingsAskFor) {
  EXPECT_THAT(stages_of(with_friction(flat(setup_of(4)))),
              ElementsAre("contact_patch", "health", "contact_gate", "equivalent_pull", "given_friction",
                          "taxel_pattern"))
      << "a friction that is given need not be read from the pad";
  EXPECT_THAT(stages_of(under_skin(setup_of(4))),
              ElementsAre("contact_patch", "health", "contact_gate", "equivalent_pull", "fit",
                          "forces_of_pad", "friction_by_forces", "taxel_pattern"));
  ChainSetup alone = under_skin(setup_of(16));
  alone.estimator.tracking = false;
  EXPECT_THAT(stages_of(alone),
              ElementsAre("contact_patch", "health", "contact_gate", "equivalent_pull", "fit",
                          "torque_reading", "forces_under_skin", "single_frame_margin", "taxel_pattern"));
}

}  // namespace
}  // namespace slipd
