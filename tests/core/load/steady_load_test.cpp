// What frames of a contact show of its load together: less noise the longer nothing turns, and no lag.
#include "core/load/steady_load.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "core/frame/significance.hpp"

namespace slipd {
namespace {

constexpr double kSigmaN = 0.01;

ContactForces with_noise(const ContactForces& of, std::mt19937& random) {
  std::normal_distribution<double> noise(0, kSigmaN);
  return {of.normal_n + noise(random), of.shear_x_n + noise(random), of.shear_y_n + noise(random)};
}

double farthest(const ContactForces& a, const ContactForces& b) {
  return std::max({std::fabs(a.normal_n - b.normal_n), std::fabs(a.shear_x_n - b.shear_x_n),
                   std::fabs(a.shear_y_n - b.shear_y_n)});
}

// Root of the mean squared error of P at each frame, over many plays with noise.
std::vector<double> errors_of(const std::function<ContactForces(int)>& load, int frames) {
  constexpr int kPlays = 200;
  std::vector<double> squares(static_cast<std::size_t>(frames));
  for (int play = 0; play < kPlays; ++play) {
    std::mt19937 random(static_cast<std::uint32_t>(play));
    SteadyLoad steady;
    for (int i = 0; i < frames; ++i) {
      steady.follow(with_noise(load(i), random), kSigmaN, kSigmaN);
      squares[static_cast<std::size_t>(i)] += std::pow(steady.now().normal_n - load(i).normal_n, 2) / kPlays;
    }
  }
  for (double& square : squares) square = std::sqrt(square);
  return squares;
}

TEST(SteadyLoad, OfALoadThatIsHeldNoiseFallsWithTheRootOfTheFrames) {
  const auto errors = errors_of([](int) { return ContactForces{2, 0.5, -0.3}; }, 1000);
  EXPECT_NEAR(errors[0], kSigmaN, 0.2 * kSigmaN);
  for (const int frames : {100, 400, 1000})
    EXPECT_LT(errors[static_cast<std::size_t>(frames - 1)], 1.5 * kSigmaN / std::sqrt(frames)) << frames;
}

TEST(SteadyLoad, ItsShareOfNoiseIsItsError) {
  std::mt19937 random(1);
  SteadyLoad steady;
  const ContactForces held{2, 0.5, -0.3};
  for (int i = 0; i < 20000; ++i) {
    steady.follow(with_noise(held, random), kSigmaN, kSigmaN);
    EXPECT_LT(farthest(steady.now(), held), 5 * steady.noise_share() * kSigmaN) << "frame " << i;
  }
  EXPECT_LT(steady.noise_share(), 0.02);
}

// A mean of the frames since its beginning would lag by half of them.
TEST(SteadyLoad, ALoadOnAStraightLineIsFollowedWithinTwoSigma) {
  for (const double sigmas_a_frame : {0.003, 0.03, 0.3, 3.0, 30.0}) {
    const auto load = [&](int i) { return ContactForces{1 + sigmas_a_frame * kSigmaN * i, 0, 0}; };
    for (const double error : errors_of(load, 1000))
      EXPECT_LT(error, 2 * kSigmaN) << sigmas_a_frame << " sigma a frame";
  }
}

TEST(SteadyLoad, AJumpIsFollowedAtOnce) {
  std::mt19937 random(2);
  SteadyLoad steady;
  for (int i = 0; i < 500; ++i) steady.follow(with_noise({2, 0.5, 0}, random), kSigmaN, kSigmaN);
  const ContactForces after = with_noise({2, 0.5 - 20 * kSigmaN, 0}, random);
  steady.follow(after, kSigmaN, kSigmaN);
  EXPECT_NEAR(steady.now().shear_x_n, after.shear_x_n, 1e-9);
  EXPECT_EQ(steady.noise_share(), 1);
}

// A step of d sigma shows against a long hold after (kStandsOutSigmas/d)^2 frames.
TEST(SteadyLoad, AStepWithinTheNoiseIsFollowedWhenFramesHaveShownIt) {
  for (const double sigmas : {1.5, 3.0}) {
    const int step_at = 500, shown_after = static_cast<int>(4 * std::pow(kStandsOutSigmas / sigmas, 2));
    const auto load = [&](int i) { return ContactForces{2 + (i < step_at ? 0 : sigmas * kSigmaN), 0, 0}; };
    const auto errors = errors_of(load, step_at + shown_after + 1);
    EXPECT_LT(errors.back(), 0.5 * sigmas * kSigmaN) << sigmas << " sigma";
  }
}

TEST(SteadyLoad, ALoadThatCurvesIsFollowedToHalfOfWhatATurnTakesToShow) {
  const auto load = [](int i) {
    return ContactForces{2 + std::sin(0.05 * i), 0.6 * std::sin(0.03 * i), 0.2 * std::cos(0.1 * i)};
  };
  for (const double error : errors_of(load, 2000)) EXPECT_LT(error, 0.5 * kStandsOutSigmas * kSigmaN);
}

TEST(SteadyLoad, WithoutNoiseEachFrameStandsForItself) {
  SteadyLoad steady;
  for (int i = 0; i < 300; ++i) {
    const ContactForces now{2 + std::sin(0.05 * i), i < 100 ? 0.5 : 0.4, 0.01 * i};
    steady.follow(now, 0, 0);
    EXPECT_LT(farthest(steady.now(), now), 1e-12) << "frame " << i;
  }
}

TEST(SteadyLoad, TheNormalForceStaysAboveZeroWhileAContactOpens) {
  std::mt19937 random(3);
  SteadyLoad steady;
  for (int i = 0; i < 400; ++i) {
    ContactForces now = with_noise({std::max(0.0, 2 - 0.01 * i), 0, 0}, random);
    now.normal_n = std::max(now.normal_n, 1e-6);
    steady.follow(now, kSigmaN, kSigmaN);
    EXPECT_GT(steady.now().normal_n, 0) << "frame " << i;
  }
}

TEST(SteadyLoad, ALoadThatTurnsAfterAMillionFramesIsFollowedAsOneThatTurnsAtOnce) {
  constexpr int kMany = 1'000'000;
  const auto held = [](int i) { return ContactForces{20, 5 + (i % 2 == 0 ? kSigmaN : -kSigmaN), 0}; };
  SteadyLoad late, early;
  for (int i = 0; i < kMany; ++i) late.follow(held(i), kSigmaN, kSigmaN);
  for (int i = 0; i < 100; ++i) early.follow(held(i), kSigmaN, kSigmaN);
  std::mt19937 random(4);
  for (int i = 0; i < 300; ++i) {
    const ContactForces now = with_noise({20 + 20 * kSigmaN * (i + 1), 5 + 0.02 * i, 0}, random);
    late.follow(now, kSigmaN, kSigmaN);
    early.follow(now, kSigmaN, kSigmaN);
    EXPECT_LT(farthest(late.now(), early.now()), 1e-6) << "frame " << i;
  }
}

}  // namespace
}  // namespace slipd
