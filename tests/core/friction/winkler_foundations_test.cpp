// Many foundations side by side follow loads as single ones do, and alike on every instruction set.
#include "core/friction/foundations/winkler_foundations.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "core/simd/instruction_sets.hpp"
#include "tests/core/contact/winkler_foundation.hpp"

namespace slipd {
namespace {

using contact::WinklerFoundation;

std::vector<double> frictions(std::size_t count) {
  std::vector<double> all;
  for (std::size_t j = 0; j < count; ++j)
    all.push_back(0.04 * std::pow(55.0, static_cast<double>(j) / static_cast<double>(count)));
  return all;
}

// The same contacts in both forms.
class Both {
 public:
  Both(std::size_t count, const WinklerKernels& kernels)
      : frictions_(frictions(count)), alone_(count), beds_(frictions_, kernels), name_(kernels.name) {}

  void follow(double normal_n, double shear_n) {
    beds_.follow(normal_n, shear_n);
    for (std::size_t j = 0; j < alone_.size(); ++j) alone_[j].follow(normal_n, shear_n, frictions_[j]);
    normal_n_ = normal_n;
    shear_n_ = shear_n;
  }
  void assume_monotonic(double normal_n, double shear_n) {
    normal_n_ = normal_n;
    shear_n_ = shear_n;
    beds_.assume_monotonic(normal_n, shear_n);
    for (std::size_t j = 0; j < alone_.size(); ++j)
      alone_[j].assume_monotonic(normal_n, shear_n, frictions_[j]);
  }
  void take_over(std::size_t from, std::size_t every) {
    const auto chosen = [every](std::size_t j) { return j % every == 1; };
    beds_.take_over(from, chosen);
    beds_.follow(normal_n_, shear_n_);  // the same load
    for (std::size_t j = 0; j < alone_.size(); ++j) {
      if (j == from || !chosen(j)) continue;
      alone_[j] = alone_[from];
      alone_[j].fall_to(frictions_[j]);
      alone_[j].follow(normal_n_, shear_n_, frictions_[j]);
    }
  }
  void clear() {
    beds_.clear();
    for (auto& bed : alone_) bed.clear();
  }

  // After a follow().
  void expect_same() {
    for (std::size_t j = 0; j < alone_.size(); ++j) {
      const auto expected = alone_[j].shear_moments(), got = beds_.shear_moments(j);
      const double limit_n = frictions_[j] * normal_n_;
      ASSERT_NEAR(got.slip_moment_n, expected.slip_moment_n, kNear * limit_n) << name_ << ", bed " << j;
      ASSERT_NEAR(got.second_legendre_n, expected.second_legendre_n, 4 * kNear * limit_n)
          << name_ << ", bed " << j;
      ASSERT_NEAR(beds_.shear_n(j), alone_[j].shear_n(), 1e-12 * limit_n) << name_ << ", bed " << j;
    }
  }

  std::vector<double> moments() const {
    std::vector<double> all;
    for (std::size_t j = 0; j < alone_.size(); ++j) {
      all.push_back(beds_.shear_moments(j).slip_moment_n);
      all.push_back(beds_.shear_moments(j).second_legendre_n);
    }
    return all;
  }

 private:
  static constexpr double kNear = 1e-3;

  std::vector<double> frictions_;
  std::vector<WinklerFoundation> alone_;
  WinklerFoundations beds_;
  const char* name_;
  double normal_n_ = 1, shear_n_ = 0;
};

constexpr int kPhases = 60, kSteps = 20;

// Presses, pulls, takes contacts over and loses them at random; the moments after each step.
std::vector<std::vector<double>> run(std::size_t count, const WinklerKernels& kernels) {
  std::mt19937_64 random(count);
  std::uniform_real_distribution<double> unit(0, 1);
  Both both(count, kernels);
  std::vector<std::vector<double>> moments;
  double p = 1, q = 0;
  both.follow(p, q);
  for (int phase = 0; phase < kPhases && !testing::Test::HasFatalFailure(); ++phase) {
    const double what = unit(random);
    if (what < 0.05) {
      both.clear();
    } else if (what < 0.1) {
      both.assume_monotonic(p, q);
    } else if (what < 0.35) {  // from the same one again, too, and from one that has taken over itself
      std::uniform_int_distribution<std::size_t> any(0, count - 1);
      const std::size_t first = any(random), second = any(random);
      for (const auto& [from, every] : {std::pair(first, 2), {first, 2}, {second, 3}, {first, 2}})
        both.take_over(from, static_cast<std::size_t>(every));
      both.expect_same();
    }
    const double p_to = what > 0.6 ? p : 0.3 + 4 * unit(random), q_to = 3 * p_to * (unit(random) - 0.5);
    for (int i = 1; i <= kSteps; ++i) {
      const double f = static_cast<double>(i) / kSteps;
      both.follow(p + f * (p_to - p), q + f * (q_to - q));
      both.expect_same();
      moments.push_back(both.moments());
    }
    p = p_to;
    q = q_to;
  }
  return moments;
}

TEST(WinklerFoundations, FollowLoadsAsSingleFoundationsDoAndAlikeOnEveryInstructionSet) {
  for (const std::size_t count : {1U, 16U, 56U, 64U}) {
    const auto expected = run(count, WinklerKernels::baseline);
    ASSERT_EQ(expected.size(), kPhases * kSteps);
    for (const WinklerKernels* kernels : kernels_at_hand<WinklerKernels>())
      ASSERT_EQ(run(count, *kernels), expected) << kernels->name << ", " << count << " beds";
  }
}

TEST(WinklerFoundations, WithoutAContactThereIsNoShape) {
  const double friction = 0.5;
  WinklerFoundations beds(std::span(&friction, 1));
  EXPECT_EQ(beds.shear_moments(0).slip_moment_n, 0);
  beds.follow(2, 5);
  EXPECT_EQ(beds.shear_n(0), 1);
  EXPECT_NEAR(beds.shear_moments(0).slip_moment_n, 2.0 / 3, 0.01)
      << "gross slip: shear lies as pressure does";
  beds.follow(0, 1);
  EXPECT_EQ(beds.shear_n(0), 0);
  EXPECT_EQ(beds.shear_moments(0).slip_moment_n, 0);
}

}  // namespace
}  // namespace slipd
