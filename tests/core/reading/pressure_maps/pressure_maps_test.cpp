// The method that knows no shape: spheres, ellipses and nearly flat contacts, read by the pressure of their
// own closing.
#include "core/reading/pressure_maps/pressure_maps.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/chain/chain.hpp"
#include "tests/support/heap_count.hpp"

namespace slipd {
namespace {

// A contact's pressure at (x, y) about its centre under a normal force: m, m, N -> Pa.
using PressureAt = std::function<double(double, double, double)>;

// Its averages over taxels. Those that were asked for are kept: each closing goes through the same forces.
class Pressure {
 public:
  explicit Pressure(PressureAt at) : at_(std::move(at)) {}
  const std::vector<float>& averages(const TaxelLayout& layout, double normal_n, double x_m,
                                     double y_m) const {
    std::vector<float>& out = known_[{layout.size(), normal_n, x_m, y_m}];
    if (!out.empty()) return out;
    constexpr int kParts = 4;
    out.resize(layout.size());
    if (normal_n <= 0) return out;
    const double part_m = layout.side_m() / kParts, corner_m = 0.5 * (part_m - layout.side_m());
    for (std::size_t i = 0; i < out.size(); ++i) {
      double sum = 0;
      for (int u = 0; u < kParts; ++u) {
        for (int v = 0; v < kParts; ++v) {
          sum += at_(layout.x_m()[i] + corner_m + u * part_m - x_m,
                     layout.y_m()[i] + corner_m + v * part_m - y_m, normal_n);
        }
      }
      out[i] = static_cast<float>(sum / (kParts * kParts));
    }
    return out;
  }

 private:
  PressureAt at_;
  mutable std::map<std::tuple<std::size_t, double, double, double>, std::vector<float>> known_;
};

// Hertz, with axes of ratio : 1, the geometric mean of which is 2 mm under 1 N.
double elliptic(double x_m, double y_m, double normal_n, double ratio) {
  const double mean_m = 2e-3 * std::cbrt(normal_n), a = mean_m * std::sqrt(ratio),
               b = mean_m / std::sqrt(ratio);
  const double inside = 1 - x_m * x_m / (a * a) - y_m * y_m / (b * b);
  return inside > 0 ? 1.5 * normal_n / (std::numbers::pi * a * b) * std::sqrt(inside) : 0;
}

// An indenter of the profile r^6: P goes with a^7; p is the integral of x^5/sqrt(x^2 - r^2) from r to a.
double nearly_flat(double x_m, double y_m, double normal_n) {
  const double a = 2.5e-3 * std::pow(normal_n, 1.0 / 7), r2 = (x_m * x_m + y_m * y_m) / (a * a);
  if (r2 >= 1) return 0;
  const double s = std::sqrt(1 - r2);
  const double shape = std::pow(s, 5) / 5 + 2 * r2 * s * s * s / 3 + r2 * r2 * s;
  // Its integral over the disc: the integral of pi x^5 * 2 sqrt... = 2 pi/7.
  return normal_n / (a * a) * shape / (2 * std::numbers::pi / 7);
}

const std::vector<std::pair<const char*, Pressure>>& shapes() {
  static const std::vector<std::pair<const char*, Pressure>> all{
      {"sphere", Pressure([](double x, double y, double n) { return elliptic(x, y, n, 1); })},
      {"ellipse", Pressure([](double x, double y, double n) { return elliptic(x, y, n, 1.7); })},
      {"nearly flat", Pressure(nearly_flat)}};
  return all;
}

// A sensor of 16 mm a side, with noise of a given half-width over the largest pressure of the frame.
class Pad {
 public:
  Pad(std::size_t side, double noise, std::uint64_t seed)
      : layout_(TaxelLayout::grid(side, side, 16e-3 / static_cast<double>(side))),
        noise_(noise),
        random_(seed),
        finder_(layout_),
        gain_(layout_.size(), 1.0F) {}

  const TaxelLayout& layout() const { return layout_; }
  // Gains of each taxel, the same for its three channels, of this standard deviation.
  void spread_gains(double sigma) {
    std::normal_distribution<float> normal(1, static_cast<float>(sigma));
    for (float& gain : gain_) gain = normal(random_);
  }
  void kill(std::size_t taxel) { gain_[taxel] = 0; }

  // Ciavarella and Jäger: q = mu (p(P) - p(gamma P)).
  const ContactPatch& sense(const Pressure& pressure, double normal_n, double gamma, double friction,
                            double direction_rad, double x_m = 0.3e-3, double y_m = -0.2e-3) {
    const std::vector<float>& now = pressure.averages(layout_, normal_n, x_m, y_m);
    const std::vector<float>& stuck = pressure.averages(layout_, gamma * normal_n, x_m, y_m);
    const float peak = *std::max_element(now.begin(), now.end());
    std::uniform_real_distribution<float> noise(-static_cast<float>(noise_) * peak,
                                                static_cast<float>(noise_) * peak);
    normal_.resize(now.size());
    x_.resize(now.size());
    y_.resize(now.size());
    for (std::size_t i = 0; i < now.size(); ++i) {
      const float shear = static_cast<float>(friction) * (now[i] - stuck[i]) * gain_[i];
      normal_[i] = gain_[i] * now[i] + noise(random_);
      x_[i] = static_cast<float>(std::cos(direction_rad)) * shear + noise(random_);
      y_[i] = static_cast<float>(std::sin(direction_rad)) * shear + noise(random_);
    }
    time_ns_ += 1'000'000;
    frame_ = Frame{static_cast<std::uint64_t>(time_ns_ / 1'000'000), time_ns_, normal_, x_, y_};
    return finder_.find(frame_);
  }
  const Frame& frame() const { return frame_; }

 private:
  TaxelLayout layout_;
  double noise_;
  std::mt19937_64 random_;
  PatchFinder finder_;
  std::vector<float> gain_, normal_, x_, y_;
  std::int64_t time_ns_ = 0;
  Frame frame_{};
};

void close_grip(PressureMaps& closing, Pad& pad, const Pressure& pressure, double most_n, int frames) {
  for (int i = 1; i <= frames; ++i) {
    const ContactPatch& patch = pad.sense(pressure, most_n * i / frames, 1, 0.5, 0);
    if (patch.in_contact) closing.observe(pad.frame(), patch);
  }
}

constexpr Range kMapsFriction{.low = 0.1, .high = 0.9};

struct Outcome {
  int asked = 0, answered = 0, within_two = 0;
  double error = 0;
  double mean_error() const { return error / answered; }
};

// One loaded frame after each of many closings.
Outcome loads(const Pressure& pressure, std::size_t side, int closings,
              const std::function<void(Pad&)>& prepare = {}) {
  Outcome out;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < closings; ++i) {
    Pad pad(side, 0.01, static_cast<std::uint64_t>(i) + 1);
    if (prepare) prepare(pad);
    PressureMaps closing(pad.layout(), kMapsFriction);
    close_grip(closing, pad, pressure, 4, 100);
    const double gamma = 0.05 + 0.9 * unit(random), friction = 0.3 + 0.5 * unit(random);
    const ContactPatch& patch = pad.sense(pressure, 3.8, gamma, friction, 6.28 * unit(random));
    const Reading estimate = closing.estimate(pad.frame(), patch);
    ++out.asked;
    if (!estimate.in_model) continue;
    ++out.answered;
    out.error += std::fabs(estimate.gamma - gamma);
    out.within_two += std::fabs(estimate.gamma - gamma) < 2 * estimate.sigma ? 1 : 0;
  }
  return out;
}

TEST(ClosingMethod, ReadsSpheresEllipsesAndNearlyFlatContacts) {
  for (const auto& [name, pressure] : shapes()) {
    const Outcome outcome = loads(pressure, 32, 60);
    EXPECT_GE(outcome.answered, 57) << name;
    EXPECT_LT(outcome.mean_error(), 0.01) << name;
    EXPECT_GE(outcome.within_two, 52) << name;
    RecordProperty(std::string(name) + " mean error", std::to_string(outcome.mean_error()));
  }
}

TEST(ClosingMethod, ReadsSixteenTaxelsASide) {
  const Outcome outcome = loads(shapes()[1].second, 16, 60);
  EXPECT_GE(outcome.answered, 55);
  EXPECT_LT(outcome.mean_error(), 0.025);
  EXPECT_GE(outcome.within_two, 50);
}

TEST(ClosingMethod, IsNotDisturbedByGainsAndDeadTaxels) {
  const Outcome outcome = loads(shapes()[0].second, 32, 40, [](Pad& pad) {
    pad.spread_gains(0.1);
    for (const std::size_t taxel : {495UL, 560UL, 400UL}) pad.kill(taxel);
  });
  EXPECT_GE(outcome.answered, 36);
  EXPECT_LT(outcome.mean_error(), 0.015);
}

class ClosedGrip : public ::testing::Test {
 protected:
  void SetUp() override { close_grip(closing_, pad_, shape_, 4, 100); }
  Reading pull(double normal_n, double gamma, double x_m = 0.3e-3) {
    const ContactPatch& patch = pad_.sense(shape_, normal_n, gamma, 0.5, 1, x_m);
    return closing_.estimate(pad_.frame(), patch);
  }

  const Pressure& shape_ = shapes()[1].second;
  Pad pad_{32, 0.01, 3};
  PressureMaps closing_{pad_.layout(), kMapsFriction};
};

TEST_F(ClosedGrip, GivesFrictionToo) {
  const Reading estimate = pull(3, 0.3);
  ASSERT_TRUE(estimate.in_model);
  EXPECT_NEAR(estimate.friction, 0.5, 0.03);
  EXPECT_LT(std::fabs(estimate.friction - 0.5), 3 * estimate.friction_sigma);
}

TEST_F(ClosedGrip, GivesNoMarginForAContactThatHasMoved) {
  EXPECT_FALSE(pull(3, 0.3, 1.3e-3).in_model);
}

TEST_F(ClosedGrip, GivesNoMarginBeyondTheForcesThatWereSeen) {
  EXPECT_FALSE(pull(5, 0.3).in_model);
}

TEST_F(ClosedGrip, GivesNoMarginForAnotherContact) {
  closing_.forget();
  EXPECT_FALSE(pull(3, 0.3).in_model);
}

TEST_F(ClosedGrip, GivesNoMarginForALoadThatWasReversed) {
  // Sticking in a disc after a load to half of its friction and back to none: shear of either sign.
  const ContactPatch& patch = pad_.sense(shape_, 3, 0.5, 0.5, 0);
  std::vector<float> x(patch.taxels.shear_x_pa, patch.taxels.shear_x_pa + pad_.layout().size());
  const ContactPatch& half = pad_.sense(shape_, 3, 0.8, 0.5, 0);
  std::vector<float> back(half.taxels.shear_x_pa, half.taxels.shear_x_pa + x.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] -= 2 * back[i];
  Frame frame = pad_.frame();
  frame.shear_x_pa = x;
  PatchFinder finder(pad_.layout());
  EXPECT_FALSE(closing_.estimate(frame, finder.find(frame)).in_model);
}

// A load to half of what friction holds that then turned back, by sums over all taxels: in a Hertz contact
// they are the moments of 7.7 in units of its ellipse.
TEST_F(ClosedGrip, GivesTheShearMomentsOfALoadThatTurnedBack) {
  constexpr double kNormal_n = 3, kCoefficient = 0.5, kAxes = 1.7, kX_m = 0.3e-3, kY_m = -0.2e-3;
  const TaxelLayout& layout = pad_.layout();
  const auto shear_of = [&](double gamma) {
    const ContactPatch& patch = pad_.sense(shape_, kNormal_n, gamma, kCoefficient, 0);
    return std::vector<float>(patch.taxels.shear_x_pa, patch.taxels.shear_x_pa + layout.size());
  };
  std::vector<float> x = shear_of(0.4);
  const std::vector<float> back = shear_of(0.8);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] -= back[i];
  Frame frame = pad_.frame();
  frame.shear_x_pa = x;
  PatchFinder finder(layout);
  const Reading estimate = closing_.estimate(frame, finder.find(frame));

  double slip_n = 0, legendre_n = 0;
  const auto add = [&](double share, double sign) {
    const double mean_m = 2e-3 * std::cbrt(kNormal_n);
    const std::vector<float>& part = shape_.averages(layout, share * kNormal_n, kX_m, kY_m);
    for (std::size_t i = 0; i < layout.size(); ++i) {
      const double u = (layout.x_m()[i] - kX_m) / mean_m, v = (layout.y_m()[i] - kY_m) / mean_m;
      const double r2 = u * u / kAxes + v * v * kAxes,
                   force_n = sign * kCoefficient * layout.area_m2() * static_cast<double>(part[i]);
      slip_n += force_n * (5.0 / 3 - 5.0 / 2 * r2);
      legendre_n += force_n * (6 * r2 * r2 - 6 * r2 + 1);
    }
  };
  add(0.8, 1);
  add(0.4, -1);
  ASSERT_TRUE(std::isfinite(estimate.moments_sigma.slip_moment_n));
  EXPECT_LT(estimate.moments_sigma.slip_moment_n, 0.05);
  EXPECT_NEAR(estimate.moments.slip_moment_n, slip_n, 3 * estimate.moments_sigma.slip_moment_n);
  EXPECT_NEAR(estimate.moments.second_legendre_n, legendre_n, 3 * estimate.moments_sigma.second_legendre_n);
  EXPECT_NEAR(estimate.moments.slip_moment_n, slip_n, 0.02 * kNormal_n);
  EXPECT_NEAR(estimate.moments.second_legendre_n, legendre_n, 0.02 * kNormal_n);
}

TEST_F(ClosedGrip, GivesMarginsOfAGripThatTightensUnderAPull) {
  EXPECT_FALSE(pull(5, 0.5).in_model);
  double normal_n = 4;
  for (double gamma = 0.3; normal_n < 8; normal_n *= 1.1, gamma += 0.05) {
    const ContactPatch& patch = pad_.sense(shape_, normal_n, gamma, 0.5, 1);
    closing_.observe(pad_.frame(), patch);
    const Reading estimate = closing_.estimate(pad_.frame(), patch);
    ASSERT_TRUE(estimate.in_model) << normal_n;
    EXPECT_NEAR(estimate.gamma, gamma, 0.05) << normal_n;
  }
}

TEST_F(ClosedGrip, RecordsNoContactThatHasMovedWhileTheGripTightens) {
  double normal_n = 4;
  for (int i = 1; i < 6; ++i) {
    normal_n *= 1.1;
    const ContactPatch& patch = pad_.sense(shape_, normal_n, 0.5, 0.5, 1, 0.3e-3 + 1e-3 * i);
    closing_.observe(pad_.frame(), patch);
    EXPECT_FALSE(closing_.estimate(pad_.frame(), patch).in_model);
  }
}

TEST_F(ClosedGrip, AllocatesNothing) {
  const ContactPatch& patch = pad_.sense(shape_, 3, 0.3, 0.5, 1);
  const std::uint64_t before = test::allocations();
  closing_.observe(pad_.frame(), patch);
  EXPECT_TRUE(closing_.estimate(pad_.frame(), patch).in_model);
  EXPECT_EQ(test::allocations(), before);
}

// A grasp in the chain: the gripper closes, then something pulls to gross slip. Adds the frames of the pull.
void pull_through_the_chain(MethodChoice method, const Pressure& pressure, double budget_us,
                            std::uint64_t seed, Outcome& out) {
  Pad pad(32, 0.01, seed);
  const ChainSetup setup{.layout = pad.layout(),
                         .scene = {},
                         .estimator = {.method = method, .budget_us = budget_us},
                         .alerts = {},
                         .friction = std::nullopt};
  EstimatorChain chain(setup, nullptr);
  for (int i = 1; i <= 100; ++i) {
    pad.sense(pressure, 0.04 * i, 1, 0.5, 0);
    chain.estimate(pad.frame());
  }
  for (int i = 1; i <= 90; ++i) {
    const double gamma = 1 - 0.01 * i;
    pad.sense(pressure, 4, gamma, 0.5, 0.4);
    const Estimate estimate = chain.estimate(pad.frame());
    ++out.asked;
    if (!estimate.gamma) continue;
    ++out.answered;
    out.error += std::fabs(*estimate.gamma - gamma);
    out.within_two += std::fabs(*estimate.gamma - gamma) < 2 * *estimate.sigma ? 1 : 0;
  }
}

// Several: the noise of a closing is common to all of its frames.
Outcome pulls_through_the_chain(MethodChoice method, const Pressure& pressure, double budget_us = 50,
                                std::uint64_t grasps = 1) {
  Outcome out;
  for (std::uint64_t seed = 1; seed <= grasps; ++seed)
    pull_through_the_chain(method, pressure, budget_us, seed, out);
  return out;
}

TEST(ClosingMethod, AnswersInTheChainForShapesThatTheContactModelDoesNotHave) {
  for (const auto& [name, pressure] : shapes()) {
    const Outcome outcome = pulls_through_the_chain(MethodChoice::closing, pressure, 50, 6);
    EXPECT_GE(outcome.answered, 0.9 * outcome.asked) << name;
    EXPECT_LT(outcome.mean_error(), 0.02) << name;
    EXPECT_GE(outcome.within_two, 0.9 * outcome.answered) << name;
  }
  EXPECT_LT(pulls_through_the_chain(MethodChoice::fit, shapes()[2].second).answered, 10);
}

// So little time that moments are chosen, and so much that fit is.
TEST(ClosingMethod, IsUsedByAutoWhereItsMethodHasNotTheShape) {
  for (const double budget_us : {1.0, 1e6}) {
    for (const auto& [name, pressure] : shapes()) {
      const Outcome outcome = pulls_through_the_chain(MethodChoice::automatic, pressure, budget_us);
      EXPECT_GE(outcome.answered, 0.9 * outcome.asked) << name << ", " << budget_us << " us";
      EXPECT_LT(outcome.mean_error(), 0.04) << name << ", " << budget_us << " us";
    }
  }
}

TEST(ClosingMethod, GivesNoMarginIfTheClosingWasNotSeen) {
  Pad pad(32, 0.01, 5);
  PressureMaps closing(pad.layout(), kMapsFriction);
  for (int i = 0; i < 50; ++i) {
    const ContactPatch& patch = pad.sense(shapes()[0].second, 3 + 0.02 * i, 1, 0.5, 0);
    closing.observe(pad.frame(), patch);
  }
  const ContactPatch& patch = pad.sense(shapes()[0].second, 3.5, 0.4, 0.5, 0);
  EXPECT_FALSE(closing.estimate(pad.frame(), patch).in_model);
}

}  // namespace
}  // namespace slipd
