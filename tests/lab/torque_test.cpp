// Contacts under force and torque carry what they are said to.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "lab/estimator.hpp"
#include "lab/frames/torque_frames.hpp"

namespace lab {
namespace {

using namespace slipd;

TEST(TorqueFrames, CarryTheShareOfFrictionThatIsAskedFor) {
  const ChainSetup chain = paper_chain(32, MethodChoice::moments, 0);
  for (std::size_t i = 0; i < 6; ++i) {
    const ContactDraw contact = draw_contact(chain.scene, 3, i);
    for (const double mix_rad : {0.0, 0.7, -1.5}) {
      std::vector<TurningMove> moves{{1, contact.normal_n, {}}};
      for (const double share : {0.3, 0.8})
        moves.push_back({4, contact.normal_n, {.share = share, .mix_rad = mix_rad, .toward_rad = 2}});
      TorqueFrames frames(contact, chain.scene.skin, chain.layout, 0, RandomStream(1), moves);
      std::vector<double> margins;  // at the end of each move
      while (frames.next()) {
        const GraspMoment& at = frames.moment();
        margins.resize(at.move + 1);
        margins.back() = at.truth.gamma;
        const FrameSlot& frame = frames.sense();
        for (std::size_t t = 0; t < chain.layout.size(); ++t)
          EXPECT_LE(std::hypot(frame.shear_x_pa[t], frame.shear_y_pa[t]),
                    static_cast<float>(contact.friction) * frame.normal_pa[t] * 1.001F + 1);
      }
      ASSERT_EQ(margins.size(), 3U);
      EXPECT_NEAR(margins[1], 1 - 0.3, 2e-3);
      EXPECT_NEAR(margins[2], 1 - 0.8, 2e-3);
    }
  }
}

}  // namespace
}  // namespace lab
