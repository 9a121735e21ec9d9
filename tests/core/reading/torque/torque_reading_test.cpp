// Histories of force and torque on an elastic half space (contact::TurningContact): what sticks after a
// regrip or a reversal is not taken for friction, memory answers meanwhile, and friction that falls is seen.
#include "core/reading/torque/torque_reading.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/chain/chain.hpp"
#include "core/contact/hertz.hpp"
#include "core/contact/history.hpp"
#include "core/contact/limit_surface.hpp"
#include "core/contact/turning_contact.hpp"
#include "core/numeric/random.hpp"
#include "paper/validation/tradeoff.hpp"
#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

constexpr double kHeldFriction = 0.6, kGripN = 2;

// What an object in the grip asks for: a share of what friction holds at kGripN, in a mixture of a pull (0)
// and a torque (pi/2).
struct HeldLoad {
  double share = 0, mix_rad = 0;
};

class HalfSpaceGrasp {
 public:
  HalfSpaceGrasp() : chain_(setup(), nullptr) {
    for (auto& channel : channels_) channel.resize(layout_.size());
    pull_.move_to(kGripN, 0, kHeldFriction);
    turning_.begin(pull_);
    move(20, kGripN, {});
  }

  struct Seen {
    Estimate estimate;
    double gamma = 0;  // true
  };

  // Grip and load go there in a straight line, at this friction.
  std::vector<Seen> move(int frames, double grip_n, const HeldLoad& load, double friction = kHeldFriction) {
    std::vector<Seen> seen;
    const contact::PlaneLoad to = plane(load), from = load_;
    const double from_n = grip_n_;
    for (int i = 1; i <= frames; ++i) {
      const double part = static_cast<double>(i) / frames;
      grip_n_ = std::lerp(from_n, grip_n, part);
      load_ = {std::lerp(from.shear_x_n, to.shear_x_n, part), 0,
               std::lerp(from.torque_nm, to.torque_nm, part)};
      turning_.move_to(grip_n_, load_, friction);
      seen.push_back({chain_.estimate(sense()), turning_.safety_margin()});
    }
    return seen;
  }

 private:
  static ChainSetup setup() {
    ChainSetup setup{.layout = TaxelLayout::grid(32, 32, 0.00045),
                     .scene = {},
                     .estimator = {.method = MethodChoice::moments},
                     .alerts = {},
                     .friction = {}};
    setup.scene.objects = paper_objects();
    return setup;
  }

  contact::PlaneLoad plane(const HeldLoad& load) const {
    const double radius_m = pull_.pair().contact_radius_m(kGripN);
    const double pull = std::cos(load.mix_rad), turn = 3 * std::numbers::pi / 16 * std::sin(load.mix_rad);
    const double unit_n = kHeldFriction * kGripN * load.share / hertz_.least_friction(pull, 0, turn).ratio;
    return {unit_n * pull, 0, unit_n * turn * radius_m};
  }

  Frame sense() {
    auto& [normal, x, y] = channels_;
    turning_.taxel_averages(layout_, 2e-4, -1e-4, normal, x, y);
    const float width = 0.01F * *std::max_element(normal.begin(), normal.end());
    const RandomStream noise = RandomStream(5).stream(++sequence_);
    for (std::size_t i = 0; i < 3; ++i) noise.stream(i).add_noise(channels_[i].data(), layout_.size(), width);
    return {sequence_, static_cast<std::int64_t>(sequence_) * 1'000'000, normal, x, y};
  }

  TaxelLayout layout_ = setup().layout;
  EstimatorChain chain_;
  contact::LoadHistory pull_{synthetic::paper_pair()};
  contact::TurningContact turning_{pull_.pair()};
  contact::LimitSurface hertz_ = contact::unit_hertz_surface();
  double grip_n_ = kGripN;
  contact::PlaneLoad load_;
  std::uint64_t sequence_ = 0;
  std::array<std::vector<float>, 3> channels_;
};

struct HistoryEnd {
  const char* name;
  double grip_n;
  HeldLoad load;
};

class TurningShapeAfter : public ::testing::TestWithParam<HistoryEnd> {};

// A tenth of friction is what a margin's error by it may be.
TEST_P(TurningShapeAfter, MarginsAreMeantAndFrictionStaysWhatItIs) {
  HalfSpaceGrasp grasp;
  grasp.move(60, kGripN, {0.75, 0.8});
  int answered = 0, frames = 0;
  for (const int count : {40, 20}) {
    for (const auto& [estimate, gamma] : grasp.move(count, GetParam().grip_n, GetParam().load)) {
      ++frames;
      if (!estimate.gamma) continue;
      ++answered;
      EXPECT_NEAR(*estimate.gamma, gamma, std::max(0.1 * (1 - gamma), 3 * *estimate.sigma)) << frames;
      EXPECT_LT(*estimate.sigma, 0.12) << frames;
      if (estimate.friction) {
        EXPECT_NEAR(*estimate.friction / kHeldFriction, 1, 0.1) << frames;
      }
    }
  }
  EXPECT_GT(answered, 0.9 * frames);
}

INSTANTIATE_TEST_SUITE_P(Histories, TurningShapeAfter,
                         ::testing::Values(HistoryEnd{"Regrip", 1.25 * kGripN, {0.75, 0.8}},
                                           HistoryEnd{"Reversal", kGripN, {0.75, -0.8}},
                                           HistoryEnd{"TorqueThatGoes", kGripN, {0.5, 0.02}},
                                           HistoryEnd{"Unloading", kGripN, {0.3, 0.8}}),
                         [](const auto& course) { return course.param.name; });

// After a regrip what sticks lies below friction, and yet friction that falls under the same swinging load is
// seen.
TEST(TorqueReading, FrictionThatFallsAfterARegripLeavesNoMarginThatIsTooSafe) {
  HalfSpaceGrasp grasp;
  grasp.move(60, kGripN, {0.75, 0.8});
  const double grip_n = 1.25 * kGripN;
  grasp.move(30, grip_n, {0.75, 0.8});
  double friction = kHeldFriction;
  int answered = 0;
  for (const double left : {0.8, 0.8}) {
    friction *= left;
    for (int swing = 0; swing < 2; ++swing) {
      grasp.move(20, grip_n, {0.55, 0.8}, friction);
      const auto risen = grasp.move(20, grip_n, {0.75, 0.8}, friction);
      const auto& [estimate, gamma] = risen.back();
      if (!estimate.gamma) continue;
      ++answered;
      EXPECT_LT(*estimate.gamma - gamma, 0.15) << friction << ' ' << swing;
    }
  }
  EXPECT_GE(answered, 3) << "of four";
}

}  // namespace
}  // namespace slipd
