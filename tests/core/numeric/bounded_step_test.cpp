#include "core/numeric/bounded_step.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>

namespace slipd {
namespace {

constexpr int kUnknowns = 5;
using Vector = Eigen::Matrix<double, kUnknowns, 1>;
using Square = Eigen::Matrix<double, kUnknowns, kUnknowns>;

// A least-squares problem as a fit has one: its Hessian is a product of slopes, scaled very differently.
struct Problem {
  Square hessian;
  Vector gradient;
};

Problem random_problem(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const auto draw = [&] { return normal(random); };
  const Eigen::Matrix<double, 12, kUnknowns> slopes =
      Eigen::Matrix<double, 12, kUnknowns>::NullaryExpr(draw) * Vector{1e-3, 1, 1e4, 1, 30}.asDiagonal();
  return {slopes.transpose() * slopes, slopes.transpose() * Eigen::Matrix<double, 12, 1>::NullaryExpr(draw)};
}

double rise(const Problem& problem, double damping, const Vector& step) {
  Square damped = problem.hessian;
  damped.diagonal() *= 1 + damping;
  return problem.gradient.dot(step) + 0.5 * step.dot(damped * step);
}

TEST(BoundedStep, NoOtherStepWithinTheBoundsLowersTheQuadraticMore) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  int held = 0;
  for (int i = 0; i < 300; ++i) {
    const Problem problem = random_problem(random);
    const double damping = i % 3 == 0 ? 0 : 0.1, least = -0.2, most = i % 2 == 0 ? 0 : 0.3;
    const Vector step = bounded_step(problem.hessian, problem.gradient, damping, 1, least, most);
    ASSERT_TRUE(step.allFinite());
    ASSERT_GE(step[1], least - 1e-12);
    ASSERT_LE(step[1], most + 1e-12);
    held += step[1] < least + 1e-9 || step[1] > most - 1e-9 ? 1 : 0;
    const double best = rise(problem, damping, step);
    EXPECT_LE(best, 0);
    for (int j = 0; j < 20; ++j) {
      Vector other = step;
      for (int k = 0; k < kUnknowns; ++k) other[k] += 0.3 * normal(random) / std::sqrt(problem.hessian(k, k));
      other[1] = std::clamp(other[1], least, most);
      EXPECT_GE(rise(problem, damping, other), best - 1e-9 * std::fabs(best));
    }
  }
  EXPECT_GT(held, 100);
  EXPECT_LT(held, 280);
}

TEST(BoundedStep, IsNotFiniteWhereNothingIsKnown) {
  EXPECT_FALSE(
      (bounded_step(Square(Square::Constant(NAN)), Vector(Vector::Ones()), 0.1, 1, -1, 1).allFinite()));
}

}  // namespace
}  // namespace slipd
