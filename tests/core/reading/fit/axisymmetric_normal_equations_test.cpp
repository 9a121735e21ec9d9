#include "core/reading/fit/normal_equations/axisymmetric_normal_equations.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "core/contact/contact_field.hpp"
#include "core/reading/fit/normal_equations/contact_shape.hpp"
#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

// A round contact on a pad of +-8 mm, by the table of AxisymmetricNormalEquations and by sheets.
class RoundTrials {
 public:
  RoundTrials(std::size_t side, double depth_m, std::optional<double> bonded_poisson = std::nullopt)
      : layout_(TaxelLayout::grid(side, side, 0.016 / static_cast<double>(side))),
        sheet_(layout_.size(), layout_.side_m(), depth_m, bonded_poisson),
        round_(layout_.side_m(), depth_m, bonded_poisson),
        data_(3 * layout_.size()),
        left_(data_.size()) {}

  // What taxels read, over the peak; and with data taken off, half the sum of squares.
  const std::vector<double>& by_table(const RoundTrial& trial) {
    round_.linearise(trial, 0.014, contact::SubsurfaceSheet::Detail::exact,
                     {.x_m = layout_.x_m().data(),
                      .y_m = layout_.y_m().data(),
                      .data_pa = data_.data(),
                      .residuals = left_.data(),
                      .count = layout_.size(),
                      .per_normal = 1,
                      .per_shear = 1},
                     products_);
    return left_;
  }
  double cost(const RoundTrial& trial) {
    double sum = 0;
    for (const double x : by_table(trial)) sum += 0.5 * x * x;
    return sum;
  }
  std::vector<double> by_sheets(const RoundTrial& trial) {
    const std::size_t n = layout_.size();
    std::vector<double> u, v, out(3 * n);
    for (std::size_t i = 0; i < n; ++i) {
      u.push_back(layout_.x_m()[i] - trial.x_m);
      v.push_back(layout_.y_m()[i] - trial.y_m);
    }
    const double k = std::cbrt(trial.gamma), q = trial.peak_pa * trial.load / (1 - trial.gamma);
    const auto add = [&](double scale, double pressed, double pulled) {
      using Sheet = contact::SubsurfaceSheet;
      sheet_.evaluate_values({scale * trial.radius_m, scale * trial.radius_m, 0}, u, v);
      const auto of = [&](Sheet::Component which, std::size_t i) {
        return sheet_.row(Sheet::value, which)[i];
      };
      const double x = pulled * std::cos(trial.direction_rad), y = pulled * std::sin(trial.direction_rad);
      for (std::size_t i = 0; i < n; ++i) {
        out[i] += pressed * of(Sheet::nn, i) + x * of(Sheet::nx, i) + y * of(Sheet::ny, i);
        out[n + i] += pressed * of(Sheet::xn, i) + x * of(Sheet::xx, i) + y * of(Sheet::xy, i);
        out[2 * n + i] += pressed * of(Sheet::yn, i) + x * of(Sheet::xy, i) + y * of(Sheet::yy, i);
      }
    };
    add(1, trial.peak_pa, q);
    add(k, 0, -k * q);
    return out;
  }
  void read(const std::vector<double>& data) { data_ = data; }
  double gradient(std::size_t unknown) const {
    constexpr std::size_t kBehindSlopes =
        AxisymmetricNormalEquations::kUnknowns * (AxisymmetricNormalEquations::kUnknowns + 1) / 2;
    return products_.pressure[kBehindSlopes + unknown] + products_.shear[kBehindSlopes + unknown];
  }
  void set_depth(double depth_m) { round_.set_depth(depth_m); }

 private:
  TaxelLayout layout_;
  contact::SubsurfaceSheet sheet_;
  AxisymmetricNormalEquations round_;
  ChannelProducts products_;
  std::vector<double> data_, left_;
};

constexpr RoundTrial kTrial{.x_m = 0.0007,
                            .y_m = -0.0004,
                            .radius_m = 0.004,
                            .peak_pa = 1,
                            .load = 0.3,
                            .gamma = 0.4,
                            .direction_rad = 0.7};

TEST(RoundFields, ByTheTableAreThoseOfSheetsToTenThousandthsOfThePeak) {
  for (const std::size_t side : {std::size_t{16}, std::size_t{32}}) {
    for (const double depth_m : {0.0005, 0.001, 0.002}) {
      for (const std::optional<double> bonded_poisson : {std::optional<double>(), std::optional(0.45)}) {
        RoundTrials trials(side, depth_m, bonded_poisson);
        const std::vector<double> table = trials.by_table(kTrial), sheets = trials.by_sheets(kTrial);
        double worst = 0;
        for (std::size_t i = 0; i < table.size(); ++i)
          worst = std::max(worst, std::fabs(table[i] - sheets[i]));
        EXPECT_LT(worst, 2e-4) << side << " " << depth_m;  // each of both within 1e-4
      }
    }
  }
}

TEST(RoundFields, HaveTheGradientOfTheirCost) {
  RoundTrials trials(32, 0.001);
  RoundTrial other = kTrial;
  other.radius_m *= 1.1;
  other.gamma = 0.6;
  other.x_m += 0.0003;
  other.direction_rad += 0.3;
  trials.read(trials.by_sheets(other));
  using Field = double RoundTrial::*;
  constexpr Field kFields[] = {&RoundTrial::x_m,          &RoundTrial::y_m,  &RoundTrial::radius_m,
                               &RoundTrial::peak_pa,      &RoundTrial::load, &RoundTrial::gamma,
                               &RoundTrial::direction_rad};
  for (std::size_t i = 0; i < std::size(kFields); ++i) {
    const double step = i < 3 ? 1e-7 : 1e-4;
    RoundTrial more = kTrial, less = kTrial;
    more.*kFields[i] += step;
    less.*kFields[i] -= step;
    const double slope = (trials.cost(more) - trials.cost(less)) / (2 * step);
    static_cast<void>(trials.by_table(kTrial));
    EXPECT_NEAR(trials.gradient(i), slope, 2e-3 * std::fabs(slope) + 1e-4) << i;
  }
}

// What the width of taxels adds to the slope is left out; here they are half as wide as deep.
TEST(RoundFields, HaveTheGradientByTheDepth) {
  RoundTrials trials(32, 0.001);
  RoundTrial other = kTrial;
  other.radius_m *= 1.1;
  other.gamma = 0.6;
  trials.read(trials.by_sheets(other));
  constexpr double kStep = 1e-3;
  trials.set_depth(0.001 * std::exp(kStep));
  const double more = trials.cost(kTrial);
  trials.set_depth(0.001 * std::exp(-kStep));
  const double slope = (more - trials.cost(kTrial)) / (2 * kStep);
  trials.set_depth(0.001);
  static_cast<void>(trials.by_table(kTrial));
  EXPECT_NEAR(trials.gradient(AxisymmetricNormalEquations::kUnknowns - 1), slope, 0.1 * std::fabs(slope));
}

// Residuals of a round contact that was fitted to an ellipse, and what the score test makes of them.
class AxesTrial {
 public:
  // axes: long over short one, at 0.5 rad; noise: standard deviation over the peak pressure.
  AxesTrial(double axes, double noise, unsigned seed, std::optional<double> bonded_poisson = std::nullopt)
      : layout_(TaxelLayout::grid(32, 32, 0.0005)),
        model_(layout_, kDepth, bonded_poisson),
        p_(layout_.size()),
        x_(p_),
        y_(p_),
        finder_(layout_) {
    const contact::BodyPair pair = synthetic::paper_pair();
    contact::LoadHistory contact(pair);
    const double normal_n = pair.disc_force_n(0.004);
    contact.move_to(normal_n, 0, 0.5);
    contact.move_to(normal_n, 0.3 * normal_n, 0.5);
    contact::ContactField sheet(layout_,
                                {.depth_m = kDepth, .bonded_poisson = bonded_poisson, .stretch = axes});
    sheet.turn(0.5);
    sheet.sense(contact, 0.0004, -0.0007, 0.6, p_, x_, y_);
    const float peak = *std::max_element(p_.begin(), p_.end());
    std::mt19937_64 random(seed);
    std::normal_distribution<float> normal(0, static_cast<float>(noise));
    for (auto* channel : {&p_, &x_, &y_}) {
      for (float& value : *channel) value += peak * normal(random);
    }
    model_.collect(finder_.find({1, 1, p_, x_, y_}), {0.006, 0.006, 0}, 0);
    model_.set_noise({noise * peak, noise * peak});
    at_ = ContactShape::Full::Zero();
    at_[ContactShape::center_x] = 0.0004;
    at_[ContactShape::center_y] = -0.0007;
    at_[ContactShape::size] = 0.004;
    at_[ContactShape::peak] = 1.5 * normal_n / (std::numbers::pi * 0.004 * 0.004);
    at_[ContactShape::load] = 0.3;
    at_[ContactShape::margin] = 0.4;
    at_[ContactShape::direction] = 0.6;
    for (int i = 0; i < 6; ++i) at_.head(ContactShape::kRound) += step(ContactShape::kRound).second;
    static_cast<void>(step(ContactShape::kRound));
  }
  double by_score() { return model_.axes_sigmas2(at_); }
  double by_newton() {
    const auto [normal, to] = step(ContactShape::kMost);
    return ContactShape::axes_sigmas2(normal.hessian, to.tail<2>());
  }

 private:
  static constexpr double kDepth = 0.001;

  std::pair<ContactShape::Normal, ContactShape::Vector> step(int unknowns) {
    ContactShape::Normal normal;
    model_.evaluate(at_, unknowns, normal);
    normal.hessian(ContactShape::depth, ContactShape::depth) = ContactShape::kHeldDepth;
    return {normal, -normal.hessian.ldlt().solve(normal.gradient)};
  }

  TaxelLayout layout_;
  ContactShape model_;
  std::vector<float> p_, x_, y_;
  PatchFinder finder_;
  ContactShape::Full at_;
};

TEST(EllipticityTest, AreAsManyDeviationsLongAsByAStepToTheEllipse) {
  for (const std::optional<double> bonded_poisson : {std::optional<double>(), std::optional(0.45)}) {
    for (const double axes : {1.01, 1.03, 1.1}) {
      for (unsigned seed = 1; seed <= 3; ++seed) {
        AxesTrial trial(axes, 0.006, seed, bonded_poisson);
        const double by_newton = std::sqrt(trial.by_newton());
        EXPECT_NEAR(std::sqrt(trial.by_score()), by_newton, 0.07 * by_newton + 0.3) << axes << " " << seed;
      }
    }
  }
}

TEST(EllipticityTest, OfRoundContactsAreNoise) {
  double sum = 0;
  constexpr unsigned kTrials = 40;
  for (unsigned seed = 1; seed <= kTrials; ++seed) sum += AxesTrial(1, 0.006, seed).by_score() / kTrials;
  EXPECT_NEAR(sum, 2, 0.9);  // chi squared of two degrees of freedom: 2 +- 2/sqrt(40)
}

}  // namespace
}  // namespace slipd
