// The whole chain on objects that turn in the grip: margin, friction, advice and the bound are those of force
// and torque together.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/chain/chain.hpp"
#include "core/contact/limit_surface.hpp"
#include "core/grasp/grasp.hpp"
#include "core/reading/fit/fit.hpp"
#include "core/reading/moments/moments.hpp"
#include "paper/validation/tradeoff.hpp"
#include "tests/support/synthetic.hpp"
#include "tests/support/turning_frames.hpp"

namespace slipd {
namespace {

using synthetic::Turned;

constexpr double kTurningFriction = 0.5;

// A grip that closes, and an object that then hangs in it off its centre of mass: pulled along `toward` and
// turned at once.
class OffCentre {
 public:
  OffCentre(TaxelLayout layout, std::optional<double> friction)
      : frames_(layout, 3), chain_(setup(layout, friction), nullptr) {}

  struct Seen {
    Estimate estimate;
    double gamma = 0;  // true
  };

  // Frames of 1 ms. `turn` is that of TurningFrames, as is `shift`.
  std::vector<Seen> hang(int frames, double shift, double turn, double toward = 0.4) {
    std::vector<Seen> seen;
    for (int i = 0; i <= frames; ++i) {
      const double part = static_cast<double>(i) / frames;
      contact_.shift_x = part * shift * std::cos(toward);
      contact_.shift_y = part * shift * std::sin(toward);
      contact_.turn = part * turn;
      seen.push_back(add());
    }
    return seen;
  }

  void close(int frames) {
    contact_.shift_x = contact_.shift_y = contact_.turn = 0;
    for (int i = 1; i <= frames; ++i) {
      contact_.peak_pa = 60e3 * std::cbrt(static_cast<double>(i) / frames);
      contact_.radius_m = 4e-3 * std::cbrt(static_cast<double>(i) / frames);
      add();
    }
  }

 private:
  static ChainSetup setup(const TaxelLayout& layout, std::optional<double> friction) {
    ChainSetup setup{.layout = layout,
                     .scene = {},
                     .estimator = {.method = MethodChoice::moments},
                     .alerts = {},
                     .friction = friction};
    setup.scene.objects = paper_objects();
    return setup;
  }

  Seen add() {
    contact_.noise = 0.01;
    Seen seen;
    seen.estimate = chain_.estimate(frames_.make(contact_));
    const double normal_n = frames_.normal_n();
    seen.gamma = 1 - hertz_.least_friction(frames_.shear_x_n() / normal_n, frames_.shear_y_n() / normal_n,
                                           frames_.torque_nm() / (normal_n * contact_.radius_m))
                             .ratio /
                         contact_.friction;
    return seen;
  }

  synthetic::TurningFrames frames_;
  EstimatorChain chain_;
  contact::LimitSurface hertz_ = contact::unit_hertz_surface();
  Turned contact_{.center_x_m = 2e-4, .center_y_m = -1e-4, .friction = kTurningFriction};
};

const TaxelLayout kFineGrid = TaxelLayout::grid(32, 32, 0.00045);

// Gamma, error by error, over all mixes of force and torque.
TEST(TurningChain, MarginAndFrictionAreThoseOfForceAndTorqueOrUnknown) {
  int answered = 0, heavy = 0;
  for (const double mix : {0.35, 0.8, 1.2, 1.57}) {
    OffCentre grasp(kFineGrid, std::nullopt);
    grasp.close(40);
    for (const auto& [estimate, gamma] : grasp.hang(120, 2.5 * std::cos(mix), -3.5 * std::sin(mix))) {
      if (gamma < 0.6) ++heavy;
      if (!estimate.gamma) continue;
      if (gamma < 0.6) ++answered;
      EXPECT_LT(*estimate.gamma - gamma, 0.15) << "too safe, mix " << mix << ", Gamma " << gamma;
      EXPECT_NEAR(*estimate.gamma, gamma, std::max(0.08, 4 * *estimate.sigma)) << mix;
      if (gamma < 0.5 && estimate.friction) {
        EXPECT_NEAR(*estimate.friction / kTurningFriction, 1, 0.1) << mix << ' ' << gamma;
      }
    }
  }
  EXPECT_GT(answered, 0.6 * heavy);
}

// A pull on its own: what noise makes of its torque changes no digit of the method's answer.
TEST(TurningChain, WithoutTorqueMarginsAreThoseOfThePullToTheLastDigit) {
  Moments moments(kFineGrid);
  Scene scene;
  scene.objects = paper_objects();
  TaxelFit fit(kFineGrid, expected_friction(scene));
  for (const MethodChoice choice : {MethodChoice::moments, MethodChoice::fit}) {
    SlipMethod& method = choice == MethodChoice::fit ? static_cast<SlipMethod&>(fit) : moments;
    ChainSetup setup{.layout = kFineGrid,
                     .scene = {},
                     .estimator = {.method = choice, .tracking = false},
                     .alerts = {},
                     .friction = {}};
    setup.scene = scene;
    EstimatorChain chain(setup, nullptr);
    PatchFinder finder(kFineGrid);
    synthetic::FrameMaker maker(kFineGrid, 7);
    int answered = 0;
    for (int i = 0; i <= 40; ++i) {
      contact::LoadHistory contact(synthetic::paper_pair());
      contact.move_to(2, 0, kTurningFriction);
      contact.move_to(2, 0.024 * i * kTurningFriction * 2, kTurningFriction);
      const Frame frame = maker.make(contact, 2e-4, -1e-4, 0.4, 0.01);
      const Estimate estimate = chain.estimate(frame);
      ASSERT_TRUE(estimate.pull_n && estimate.shear_n);
      EXPECT_EQ(*estimate.pull_n, *estimate.shear_n);
      if (!estimate.gamma) continue;
      ++answered;
      const Reading alone = method.estimate(frame, finder.find(frame));
      EXPECT_EQ(*estimate.gamma, alone.gamma) << i;
      EXPECT_EQ(*estimate.friction, alone.friction) << i;
    }
    EXPECT_GT(answered, 30);
  }
}

TEST(TurningChain, FewTaxelsWithAGivenFrictionCountTheTorque) {
  OffCentre grasp(TaxelLayout::grid(4, 4, 0.0025), kTurningFriction);
  grasp.close(40);
  double errors = 0;
  int answered = 0;
  for (const auto& [estimate, gamma] : grasp.hang(120, 1.2, 2.0)) {
    if (!estimate.gamma) continue;
    ++answered;
    errors += std::fabs(*estimate.gamma - gamma);
    EXPECT_LT(*estimate.gamma - gamma, 0.15) << gamma;
  }
  EXPECT_GT(answered, 100);
  EXPECT_LT(errors / answered, 0.06);
}

TEST(TurningChain, TheBoundAndTheAdviceCountTheTorque) {
  OffCentre grasp(kFineGrid, kTurningFriction);
  grasp.close(40);
  const auto seen = grasp.hang(120, 0.5, 2.0);
  const auto& [estimate, gamma] = seen.back();
  ASSERT_TRUE(estimate.gamma && estimate.gamma_low && estimate.torque_nm && estimate.torque_sigma_nm &&
              estimate.pull_n);
  EXPECT_GT(*estimate.torque_nm, 10 * *estimate.torque_sigma_nm);
  EXPECT_LT(*estimate.gamma_low, gamma);
  EXPECT_GT(*estimate.pull_n, 1.2 * *estimate.shear_n);
  ASSERT_TRUE(estimate.grip_increase_n && estimate.friction);
  const double target = AlertSettings().target_margin;
  EXPECT_NEAR(*estimate.grip_increase_n,
              std::max(0.0, *estimate.pull_n / (*estimate.friction * (1 - target)) - *estimate.normal_n),
              1e-9);
}

TEST(TurningChain, AGraspAddsUpWhatItsFingersAskOfFriction) {
  Estimate finger;
  finger.state = State::ok;
  finger.gamma = 0.5;
  finger.friction = 0.5;
  finger.normal_n = 4;
  finger.shear_n = 0.2;
  finger.pull_n = 1;
  const std::vector<Estimate> fingers{finger, finger};
  EXPECT_NEAR(*grasp_estimate(fingers, 0.5).gamma, 0.5, 1e-12);
}

// After a torque has gone the contact keeps traction of its own, and memory of friction stays.
TEST(TurningChain, ATorqueThatCameAndWentLeavesNoMarginThatIsTooSafe) {
  OffCentre grasp(kFineGrid, std::nullopt);
  grasp.close(40);
  grasp.hang(80, 0.6, 2.5);
  int answered = 0;
  for (const auto& [estimate, gamma] : grasp.hang(100, 1.2, 0.02)) {
    if (!estimate.gamma) continue;
    ++answered;
    EXPECT_LT(*estimate.gamma - gamma, 0.15) << gamma;
  }
  EXPECT_GT(answered, 60) << "of 100";
}

}  // namespace
}  // namespace slipd
