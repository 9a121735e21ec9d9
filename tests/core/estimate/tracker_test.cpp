#include "core/estimate/tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/estimate/chain.hpp"
#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

using synthetic::FrameMaker;
using synthetic::Noise;

struct Phase {
  const char* name;
  int ms;
  double normal_from, normal_to, shear_from, shear_to, friction;
};

// A gripper's ordinary life: grip, load, regrip, load on, unload, reverse, back, loosen, grease, slip,
// regrip, let go.
const std::vector<Phase> kLife{{"grip", 200, 0.05, 2, 0, 0, 0.5},      {"load", 300, 2, 2, 0, 0.8, 0.5},
                               {"regrip", 100, 2, 3, 0.8, 0.8, 0.5},   {"hold", 100, 3, 3, 0.8, 0.8, 0.5},
                               {"load on", 300, 3, 3, 0.8, 1.4, 0.5},  {"unload", 200, 3, 3, 1.4, 0.3, 0.5},
                               {"reverse", 200, 3, 3, 0.3, -0.9, 0.5}, {"back", 200, 3, 3, -0.9, 0.6, 0.5},
                               {"loosen", 100, 3, 2, 0.6, 0.6, 0.5},   {"grease", 100, 2, 2, 0.6, 0.6, 0.35},
                               {"slip", 100, 2, 2, 0.6, 0.75, 0.35},   {"regrip", 100, 2, 3, 0.7, 0.7, 0.35},
                               {"let go", 100, 3, 0, 0.7, 0, 0.35},    {"nothing", 50, 0, 0, 0, 0, 0.7}};

struct Tally {
  int frames = 0, ok = 0;
  double error = 0, worst = 0, too_safe = 0;
};

Tally live(EstimatorChain& chain, FrameMaker& maker, const std::vector<Phase>& life, double noise,
           Noise kind) {
  contact::LoadHistory contact(synthetic::paper_pair());
  Tally tally;
  for (const auto& phase : life) {
    for (int i = 1; i <= phase.ms; ++i) {
      const double f = static_cast<double>(i) / phase.ms;
      contact.move_to(phase.normal_from + f * (phase.normal_to - phase.normal_from),
                      phase.shear_from + f * (phase.shear_to - phase.shear_from), phase.friction);
      const Estimate estimate = chain.estimate(maker.make(contact, 0, 0, 0.3, noise, kind));
      ++tally.frames;
      EXPECT_EQ(estimate.gamma.has_value(), estimate.state == State::ok);
      if (estimate.state != State::ok || contact.normal_n() == 0) continue;
      const double off = *estimate.gamma - contact.safety_margin();
      ++tally.ok;
      tally.error += std::fabs(off);
      tally.worst = std::max(tally.worst, std::fabs(off));
      tally.too_safe = std::max(tally.too_safe, off);
      EXPECT_LT(std::fabs(off), 0.25) << phase.name << " " << i;
      EXPECT_LT(off, 0.15) << phase.name << " " << i;
    }
  }
  tally.error /= std::max(1, tally.ok);
  return tally;
}

ChainSetup setup_for(std::size_t side, MethodChoice method) {
  ChainSetup setup{.layout = TaxelLayout::grid(side, side, 0.0144 / static_cast<double>(side)),
                   .scene = {},
                   .estimator = {},
                   .alerts = {},
                   .friction = {}};
  setup.scene.objects = paper_objects();
  setup.estimator.method = method;
  return setup;
}

TEST(Tracker, FollowsAGrippersLifeThroughRegripUnloadingReversalAndGrease) {
  for (const auto kind : {Noise::relative, Noise::sensor}) {
    const ChainSetup setup = setup_for(100, MethodChoice::fit);
    EstimatorChain chain(setup, nullptr);
    FrameMaker maker(setup.layout);
    const Tally tally = live(chain, maker, kLife, 0.01, kind);
    EXPECT_LT(tally.error, 0.03);
    EXPECT_GT(tally.ok, 0.8 * tally.frames);
  }
}

TEST(Tracker, WithMomentsNoMarginIsFarOffEither) {
  const ChainSetup setup = setup_for(100, MethodChoice::moments);
  EstimatorChain chain(setup, nullptr);
  FrameMaker maker(setup.layout);
  live(chain, maker, kLife, 0.01, Noise::relative);
}

TEST(Tracker, AContactThatSticksAllOverWhileBothForcesGrowIsNotTakenForSliding) {
  const ChainSetup setup = setup_for(100, MethodChoice::fit);
  EstimatorChain chain(setup, nullptr);
  FrameMaker maker(setup.layout);
  const Tally tally =
      live(chain, maker, {{"grip under load", 100, 0.02, 2, 0.005, 0.5, 0.7}}, 0.01, Noise::relative);
  EXPECT_EQ(tally.ok, 0) << "stuck or sliding: one frame looks like the other";
}

TEST(Tracker, AGrownLoadThatSlidesIsNeverCalledSafe) {
  const ChainSetup setup = setup_for(100, MethodChoice::fit);
  EstimatorChain chain(setup, nullptr);
  FrameMaker maker(setup.layout);
  live(chain, maker,
       {{"grip", 100, 0.05, 2, 0, 0, 0.4},
        {"load", 200, 2, 2, 0, 0.8, 0.4},
        {"slide", 100, 2, 3, 0.8, 1.2, 0.4}},
       0.01, Noise::relative);
}

}  // namespace
}  // namespace slipd
