// What `slipd-lab torque` counts, and that its contacts carry what they are said to.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "lab/histories/drive.hpp"
#include "lab/torque/grasp.hpp"

namespace lab {
namespace {

using namespace slipd;

TEST(TurningTallies, CountErrorsAboveTheTruthAndFrictionWhereSlipIsNear) {
  TurningTally tally;
  Estimate estimate;
  estimate.state = State::ok;
  estimate.gamma = 0.7;
  estimate.sigma = 0.05;
  estimate.friction = 0.55;
  tally.add(estimate, {.gamma = 0.5, .friction = 0.5}, 3);
  estimate.gamma = 0.4;
  estimate.friction = 0.5;
  tally.add(estimate, {.gamma = 0.5, .friction = 0.4}, 5);
  tally.add(Estimate{}, {.gamma = 0.9, .friction = 0.4}, 4);
  EXPECT_DOUBLE_EQ(tally.too_safe(), 0.5);
  EXPECT_NEAR(tally.most_too_safe(), 0.2, 1e-12);
  EXPECT_NEAR(tally.bias(), 0.05, 1e-12);
  EXPECT_NEAR(tally.friction_error(), (0.1 + 0.25) / 2, 1e-12);
  EXPECT_DOUBLE_EQ(tally.answered_near(), 1);
  EXPECT_DOUBLE_EQ(tally.median_us(), 4);
}

TEST(TurningGrasps, CarryTheShareOfFrictionThatIsAskedFor) {
  const ChainSetup chain = paper_chain(32, MethodChoice::moments, 0);
  for (std::size_t i = 0; i < 6; ++i) {
    const ContactDraw contact = draw_contact(chain.scene, 3, i);
    for (const double mix_rad : {0.0, 0.7, -1.5}) {
      TurningGrasp grasp(contact, chain.scene.skin, chain.layout, 0, RandomStream(1));
      grasp.play({1, contact.normal_n, {}}, [](const Frame&, Truth) {});
      for (const double share : {0.3, 0.8}) {
        grasp.play({4, contact.normal_n, {.share = share, .mix_rad = mix_rad, .toward_rad = 2}},
                   [](const Frame&, Truth) {});
        grasp.play({1, contact.normal_n, {.share = share, .mix_rad = mix_rad, .toward_rad = 2}},
                   [&](const Frame& frame, Truth truth) {
                     EXPECT_NEAR(truth.gamma, 1 - share, 2e-3);
                     for (std::size_t t = 0; t < chain.layout.size(); ++t)
                       EXPECT_LE(std::hypot(frame.shear_x_pa[t], frame.shear_y_pa[t]),
                                 static_cast<float>(contact.friction) * frame.normal_pa[t] * 1.001F + 1);
                   });
      }
    }
  }
}

}  // namespace
}  // namespace lab
