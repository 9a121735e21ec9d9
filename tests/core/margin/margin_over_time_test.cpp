#include "core/margin/margin_over_time.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "core/chain/chain.hpp"
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

// A grasp: grip, load, regrip, load further, unload, reverse, load again, loosen, friction falls, slip,
// regrip, release.
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
  double friction = life.front().friction;  // of the phase before
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
      // A fall of friction is told within three frames.
      if (phase.friction < friction && i <= 3) continue;
      EXPECT_LT(std::fabs(off), 0.25) << phase.name << " " << i;
      EXPECT_LT(off, 0.15) << phase.name << " " << i << " truth " << contact.safety_margin() << " sigma "
                           << *estimate.sigma;
    }
    friction = phase.friction;
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

TEST(MarginOverTime, FollowsAGraspThroughRegripUnloadingReversalAndAFallOfFriction) {
  for (const auto kind : {Noise::relative, Noise::sensor}) {
    const ChainSetup setup = setup_for(100, MethodChoice::fit);
    EstimatorChain chain(setup, nullptr);
    FrameMaker maker(setup.layout);
    const Tally tally = live(chain, maker, kLife, 0.01, kind);
    EXPECT_LT(tally.error, 0.03);
    EXPECT_GT(tally.ok, 0.8 * tally.frames);
  }
}

TEST(MarginOverTime, WithMomentsNoMarginIsFarOffEither) {
  const ChainSetup setup = setup_for(100, MethodChoice::moments);
  EstimatorChain chain(setup, nullptr);
  FrameMaker maker(setup.layout);
  const Tally tally = live(chain, maker, kLife, 0.01, Noise::relative);
  EXPECT_GT(tally.ok, 0.75 * tally.frames);
}

TEST(MarginOverTime, AContactThatSticksEverywhereWhileBothForcesGrowIsNotTakenForSliding) {
  const ChainSetup setup = setup_for(100, MethodChoice::fit);
  EstimatorChain chain(setup, nullptr);
  FrameMaker maker(setup.layout);
  const Tally tally =
      live(chain, maker, {{"grip under load", 100, 0.02, 2, 0.005, 0.5, 0.7}}, 0.01, Noise::relative);
  EXPECT_EQ(tally.ok, 0) << "stuck or sliding: one frame looks like the other";
}

// Grasps of new objects on 4 x 4 taxels of 4.7 mm: grip, load to slip, regrip, unload, load again.
Tally grasp_on_few_taxels(const TaxelLayout& layout, double noise, int grasps, int& right_after_slip,
                          int& after_slip) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> unit(0, 1);
  ChainSetup setup = setup_for(4, MethodChoice::automatic);
  setup.layout = layout;
  if (layout.size() == 1) setup.sensor_class = SensorClass::wrench;
  Tally tally;
  for (int grasp = 0; grasp < grasps; ++grasp) {
    EstimatorChain chain(setup, nullptr);
    FrameMaker maker(layout, static_cast<std::uint64_t>(grasp) + 1);
    contact::LoadHistory contact(synthetic::random_pair(random));
    const double p = 1 + 4 * unit(random), mu = 0.1 + 0.8 * unit(random);
    const double x = 0.002 * (2 * unit(random) - 1), y = 0.002 * (2 * unit(random) - 1);
    bool slipped = false;
    for (const Phase& phase :
         {Phase{"grip", 50, 0.2, p, 0, 0, mu}, Phase{"load to slip", 200, p, p, 0, 1.05 * mu * p, mu},
          Phase{"regrip", 60, p, 1.4 * p, mu * p, mu * p, mu},
          Phase{"unload", 100, 1.4 * p, 1.4 * p, mu * p, 0.3 * mu * p, mu},
          Phase{"load", 150, 1.4 * p, 1.4 * p, 0.3 * mu * p, mu * p, mu}}) {
      for (int i = 1; i <= phase.ms; ++i) {
        const double f = static_cast<double>(i) / phase.ms;
        contact.move_to(phase.normal_from + f * (phase.normal_to - phase.normal_from),
                        phase.shear_from + f * (phase.shear_to - phase.shear_from), mu);
        const Estimate estimate = chain.estimate(maker.make(contact, x, y, 0.4, noise, Noise::sensor));
        slipped = slipped || contact.safety_margin() < 1e-9;
        ++tally.frames;
        after_slip += slipped ? 1 : 0;
        if (!estimate.gamma) continue;
        const double off = *estimate.gamma - contact.safety_margin();
        ++tally.ok;
        tally.error += std::fabs(off);
        tally.too_safe += off > 0.2 ? 1 : 0;
        right_after_slip +=
            slipped && slip_class(*estimate.gamma) == slip_class(contact.safety_margin()) ? 1 : 0;
      }
    }
  }
  tally.error /= std::max(1, tally.ok);
  return tally;
}

TEST(MarginOverTime, FourByFourTaxelsLearnFrictionOverAGrasp) {
  int right = 0, after = 0;
  const Tally tally = grasp_on_few_taxels(TaxelLayout::grid(4, 4, 0.0047), 0.01, 40, right, after);
  EXPECT_GT(right, 0.7 * after);
  EXPECT_LT(tally.error, 0.06);
  EXPECT_LT(tally.too_safe, 0.01 * tally.ok);
}

TEST(MarginOverTime, OneForceVectorGetsNoMarginThatIsTooSafe) {
  int right = 0, after = 0;
  const Tally tally = grasp_on_few_taxels(TaxelLayout::wrench(0.0188), 0, 40, right, after);
  EXPECT_EQ(tally.too_safe, 0);
  EXPECT_LT(tally.ok, tally.frames) << "friction is not known before anything slipped";
  EXPECT_GT(tally.ok, 0.5 * tally.frames) << "and known afterwards";
}

TEST(MarginOverTime, AGrownLoadThatSlidesIsNeverCalledSafe) {
  const ChainSetup setup = setup_for(100, MethodChoice::fit);
  EstimatorChain chain(setup, nullptr);
  FrameMaker maker(setup.layout);
  const Tally tally = live(chain, maker,
                           {{"grip", 100, 0.05, 2, 0, 0, 0.4},
                            {"load", 200, 2, 2, 0, 0.8, 0.4},
                            {"slide", 100, 2, 3, 0.8, 1.2, 0.4}},
                           0.01, Noise::relative);
  EXPECT_GT(tally.ok, 0.9 * tally.frames);
}

// A source with a decision and the path of the forces, as a pipeline has them.
class Source {
 public:
  Source(const FrictionKnowledge& friction, bool needs_history)
      : source_(make_margin_over_time(EstimatorSettings{}.sigma_max, friction, needs_history)) {}

  void update(const ContactPatch& patch, const Reading* reading, const MarginProfile* shared, Estimate& out) {
    MarginDecision decision(EstimatorSettings{}.sigma_max);
    const SlidingVerdict unknown;
    const bool under_torque = reading != nullptr && reading->under_torque;
    source_->estimate({.measured = patch,
                       .step = path_.follow(load_of(out.time_ns, patch, patch, under_torque)),
                       .acting = patch,
                       .reading = reading,
                       .shared = shared,
                       .previous_sliding = unknown},
                      decision, out);
    decision.apply(out);
  }

 private:
  std::unique_ptr<MarginSource> source_;
  LoadPath path_;
};

TEST(MarginOverTime, FewTaxelsWhoseFramesNoFrictionExplainsAreOutOfTheModel) {
  Source source({.expected = {0.1, 0.9}, .given = std::nullopt}, true);
  ContactPatch patch;
  patch.normal_n = 2;
  patch.shear_n = patch.shear_x_n = 0.5;
  patch.shear_sigma_n = 0.01;
  Reading nonsense;
  nonsense.by = Method::fit;
  nonsense.in_model = true;
  nonsense.gamma = 9;
  nonsense.sigma = 0.01;
  Estimate estimate;
  for (int i = 1; i <= 50; ++i) {
    estimate.time_ns = i * 1'000'000;
    source.update(patch, &nonsense, nullptr, estimate);
  }
  EXPECT_EQ(estimate.state, State::out_of_model);
}

// A load with a torque that shows friction, and then falls to a share of its maximum at which all sticks.
double sigma_below_the_maximum(const std::optional<KnownFriction>& friction, double share) {
  constexpr double kMost_n = 0.8, kNormal_n = 2, kFriction = 0.5;
  Source source({.expected = {0.1, 0.9}, .given = friction}, false);
  ContactPatch patch;
  patch.normal_n = kNormal_n;
  patch.normal_sigma_n = patch.shear_sigma_n = 1e-3;
  patch.radius_m = 4e-3;
  Reading frame;
  frame.by = Method::moments;
  frame.under_torque = true;
  Estimate estimate;
  for (int i = 1; i <= 120; ++i) {
    const bool fallen = i > 40;
    estimate = {};
    estimate.time_ns = i * 1'000'000;
    const double now = 1 - (1 - share) * std::clamp((i - 40) / 60.0, 0.0, 1.0);
    patch.shear_n = patch.shear_x_n = now * kMost_n;
    frame.in_model = !fallen;
    frame.load_fallen = fallen;
    frame.gamma = 1 - patch.shear_n / (kFriction * kNormal_n);
    frame.sigma = 0.02;
    frame.common_sigma = 0.005;
    frame.friction = now * kFriction;
    frame.friction_sigma = 0.015;
    source.update(patch, &frame, nullptr, estimate);
  }
  EXPECT_TRUE(estimate.gamma) << share;
  return estimate.sigma.value_or(0);
}

// Of a flat pad whose load has only risen.
TEST(MarginOverTime, WhatTheTaxelsOfAFlatPadShowLowersTheMarginAndNeverRaisesIt) {
  const auto margin = [](const MarginProfile* shared) {
    Source source({.expected = {0.3, 1}, .given = KnownFriction(Range{0.3, 1})}, true);
    Estimate out;
    ContactPatch patch;
    patch.in_contact = true;
    patch.normal_n = 5;
    patch.normal_sigma_n = patch.shear_sigma_n = 0.005;
    for (int i = 0; i <= 100; ++i) {
      patch.shear_n = patch.shear_x_n = 0.008 * i;
      out = {};
      out.time_ns = 1'000'000 * (i + 1);
      source.update(patch, nullptr, shared, out);
    }
    return out.gamma.value_or(-1);
  };
  MarginProfile slips{.known = true, .misfit = {}}, sticks = slips, unknown = slips;
  for (std::size_t j = 0; j < MarginProfile::kSteps; ++j) {
    slips.misfit[j] = 30 * MarginProfile::gamma_of(j);
    sticks.misfit[j] = 30 * (1 - MarginProfile::gamma_of(j));
  }
  unknown.known = false;
  const double by_forces = margin(nullptr);
  ASSERT_GT(by_forces, 0.5);
  EXPECT_EQ(margin(&unknown), by_forces);
  EXPECT_EQ(margin(&sticks), by_forces);
  EXPECT_LT(margin(&slips), by_forces - 0.1);
}

TEST(MarginOverTime, UnderATorqueSigmaCoversFrictionThatMayHaveFallenUnseenBelowTheLoadsMaximum) {
  const double near = sigma_below_the_maximum(std::nullopt, 0.9),
               below = sigma_below_the_maximum(std::nullopt, 0.6),
               far = sigma_below_the_maximum(std::nullopt, 0.3);
  EXPECT_GT(below, near + 0.005);
  EXPECT_GT(far, below + 0.02);
  EXPECT_LT(sigma_below_the_maximum(0.5, 0.3), near) << "a value that is given does not fall";
}

}  // namespace
}  // namespace slipd
