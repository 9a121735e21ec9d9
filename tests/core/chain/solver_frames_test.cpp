// Frames of contacts under force and torque from a boundary-element solver that shares no equation with
// slipd: a half space with Cerruti's kernel, |q| <= mu p and the least elastic energy, for round, elliptic
// and tilted pressures (tests/data/force-and-torque.bin: four numbers a frame, then counts of three
// channels). Margin and friction are those of the solver.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "core/chain/chain.hpp"
#include "core/load/equivalent_pull.hpp"
#include "paper/model_setup.hpp"
#include "paper/train.hpp"

namespace slipd {
namespace {

constexpr std::size_t kAcross = 32;
constexpr std::size_t kSolverTaxels = kAcross * kAcross;

struct SolverFrame {
  double friction = 0;        // mu
  double least_friction = 0;  // that carries the load: Gamma = 1 - least_friction/friction
  double radius_m = 0;
  double peak_pa = 0;
  std::array<std::vector<float>, 3> channels;  // normal, shear x, shear y, Pa

  double gamma() const { return 1 - least_friction / friction; }
};

std::vector<SolverFrame> solver_frames() {
  constexpr float kFullCount = 32000;  // of the peak
  std::ifstream in(SLIPD_SOURCE_DIR "/tests/data/force-and-torque.bin", std::ios::binary);
  std::vector<SolverFrame> frames;
  std::array<double, 4> head{};
  std::vector<std::int16_t> counts(3 * kSolverTaxels);
  while (in.read(reinterpret_cast<char*>(head.data()), sizeof head) &&
         in.read(reinterpret_cast<char*>(counts.data()), 3 * kSolverTaxels * sizeof(std::int16_t))) {
    SolverFrame frame{.friction = head[0],
                      .least_friction = head[1],
                      .radius_m = head[2],
                      .peak_pa = head[3],
                      .channels = {}};
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < kSolverTaxels; ++i)
        frame.channels[c].push_back(static_cast<float>(frame.peak_pa) *
                                    static_cast<float>(counts[c * kSolverTaxels + i]) / kFullCount);
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

// With noise of a half-width that is a share of the peak, averaged over taxels of `pooled` x `pooled`.
class Sensor {
 public:
  explicit Sensor(std::size_t pooled)
      : pooled_(pooled),
        layout_(TaxelLayout::grid(kAcross / pooled, kAcross / pooled,
                                  0.0144 / kAcross * static_cast<double>(pooled))) {}

  Frame read(const SolverFrame& from, double noise) {
    const std::size_t across = kAcross / pooled_;
    std::uniform_real_distribution<float> unit(-1, 1);
    const auto width = static_cast<float>(noise * from.peak_pa);
    for (std::size_t c = 0; c < 3; ++c) {
      channels_[c].assign(layout_.size(), 0);
      for (std::size_t i = 0; i < kSolverTaxels; ++i)
        channels_[c][i / kAcross / pooled_ * across + i % kAcross / pooled_] +=
            from.channels[c][i] / static_cast<float>(pooled_ * pooled_);
      for (float& value : channels_[c]) value += width * unit(random_);
    }
    ++sequence_;
    return {sequence_, static_cast<std::int64_t>(sequence_) * 1'000'000, channels_[0], channels_[1],
            channels_[2]};
  }
  const TaxelLayout& layout() const { return layout_; }

 private:
  std::size_t pooled_;
  TaxelLayout layout_;
  std::mt19937_64 random_{5};
  std::array<std::vector<float>, 3> channels_;
  std::uint64_t sequence_ = 0;
};

TEST(SolverFrames, TheLimitSurfaceIsThatOfTheSolverWithinOnePercent) {
  const auto frames = solver_frames();
  ASSERT_GE(frames.size(), 12U);
  Sensor sensor(1);
  PatchFinder finder(sensor.layout());
  PullOfTaxels load(sensor.layout());
  for (const SolverFrame& frame : frames) {
    const ContactPatch& patch = finder.find(sensor.read(frame, 0));
    EXPECT_NEAR(load.of(patch, TorqueEffect::none).pull_n / patch.normal_n / frame.least_friction, 1, 0.01)
        << frame.gamma();
  }
}

// The model of a method that needs one, for a scene of the paper.
std::shared_ptr<const Model> model_for(const ChainSetup& setup) {
  if (!needs_model(setup)) return nullptr;
  ModelSetup wanted = model_setup_of(setup);
  wanted.size = {.contacts = 160, .loads = 40};
  return std::make_shared<const Model>(train(wanted));
}

struct Reach {
  MethodChoice method;
  std::size_t pooled;
  double mean_error, answered;
};

class SolverFramesBy : public ::testing::TestWithParam<Reach> {};

// Each frame by itself, with 1 % of sensor noise, ten times.
TEST_P(SolverFramesBy, MarginsAreMeantAndFrictionIsRightOrUnknown) {
  const Reach& reach = GetParam();
  Sensor sensor(reach.pooled);
  ChainSetup setup{.layout = sensor.layout(),
                   .scene = {},
                   .estimator = {.method = reach.method, .tracking = false},
                   .alerts = {},
                   .friction = {}};
  setup.scene.objects = paper_objects();
  const std::shared_ptr<const Model> model = model_for(setup);
  double errors = 0;
  int answered = 0, within = 0, frames = 0, wrong = 0;
  for (const SolverFrame& frame : solver_frames()) {
    EstimatorChain chain(setup, model);  // a jump from contact to contact is implausible
    for (int i = 0; i < 10; ++i, ++frames) {
      const Estimate estimate = chain.estimate(sensor.read(frame, 0.01));
      if (!estimate.gamma) continue;
      const double off = *estimate.gamma - frame.gamma();
      ++answered;
      errors += std::fabs(off);
      within += std::fabs(off) < 2 * *estimate.sigma ? 1 : 0;
      wrong += estimate.friction && std::fabs(*estimate.friction / frame.friction - 1) > 0.1 ? 1 : 0;
      EXPECT_LT(off, 0.15) << "too safe, Gamma " << frame.gamma();
    }
  }
  EXPECT_LT(errors / answered, reach.mean_error);
  EXPECT_GT(answered, reach.answered * frames);
  RecordProperty("answered", std::to_string(static_cast<double>(answered) / frames));
  RecordProperty("mean_error", std::to_string(errors / answered));
  EXPECT_GT(within, 0.9 * answered);
  EXPECT_LT(wrong, 0.03 * answered);
}

INSTANTIATE_TEST_SUITE_P(Methods, SolverFramesBy,
                         ::testing::Values(Reach{MethodChoice::moments, 1, 0.03, 0.9},
                                           Reach{MethodChoice::fit, 1, 0.03, 0.9},
                                           Reach{MethodChoice::automatic, 1, 0.03, 0.9},
                                           Reach{MethodChoice::registered, 1, 0.03, 0.9},
                                           Reach{MethodChoice::fit, 2, 0.05, 0.9},
                                           Reach{MethodChoice::moments, 2, 0.05, 0.9}));

// A frame whose shear is so far on its way from none, 0 … 1.
SolverFrame part_of(const SolverFrame& frame, float share) {
  SolverFrame part = frame;
  for (const std::size_t shear : {1, 2}) {
    for (float& value : part.channels[shear]) value *= share;
  }
  return part;
}

// Flat skins: taxels' shear means nothing by itself, and single frames show no friction.
TEST(SolverFrames, OnAFlatPadALargeTorqueTakesTheMarginAndTheLowOneCountsAll) {
  constexpr int kGripped = 400, kLoading = 100, kHeld = 100;  // frames of 1 ms
  for (const bool value : {true, false}) {
    Sensor sensor(4);
    int held = 0, answered = 0;
    for (const SolverFrame& frame : solver_frames()) {
      ChainSetup setup{.layout = sensor.layout(), .scene = {}, .estimator = {}, .alerts = {}, .friction = {}};
      setup.scene.skin.radius_m = std::numeric_limits<double>::infinity();
      setup.scene.objects = paper_objects();
      setup.friction = value ? KnownFriction(frame.friction)
                             : KnownFriction(Range{0.8 * frame.friction, 1.25 * frame.friction});
      EstimatorChain chain(setup, nullptr);
      for (int i = 0; i < kGripped; ++i) chain.estimate(sensor.read(part_of(frame, 0), 0.01));
      for (int i = 1; i <= kLoading; ++i)
        chain.estimate(sensor.read(part_of(frame, static_cast<float>(i) / kLoading), 0.01));
      for (int i = 0; i < kHeld; ++i) {
        const Estimate estimate = chain.estimate(sensor.read(frame, 0.01));
        ASSERT_TRUE(estimate.gamma_low);
        EXPECT_LT(*estimate.gamma_low, frame.gamma() + 0.03) << value;
        ++held;
        if (!estimate.gamma) continue;
        ++answered;
        EXPECT_LT(*estimate.gamma - frame.gamma(), 0.33) << "too safe, friction given " << value;
      }
    }
    EXPECT_GT(answered, 0.25 * held) << value;
  }
}

// 4 x 4 taxels that are given the friction, after a grip without load.
TEST(SolverFrames, FewTaxelsWithAGivenFrictionCountTheTorque) {
  Sensor sensor(8);
  double errors = 0;
  int answered = 0, within = 0, frames = 0;
  for (const SolverFrame& frame : solver_frames()) {
    ChainSetup setup{
        .layout = sensor.layout(), .scene = {}, .estimator = {}, .alerts = {}, .friction = frame.friction};
    setup.scene.objects = paper_objects();
    EstimatorChain chain(setup, nullptr);
    SolverFrame gripped = frame;
    for (const std::size_t shear : {1, 2}) gripped.channels[shear].assign(kSolverTaxels, 0);
    for (int i = 0; i < 10; ++i) chain.estimate(sensor.read(gripped, 0.01));
    for (int i = 0; i < 10; ++i, ++frames) {
      const Estimate estimate = chain.estimate(sensor.read(frame, 0.01));
      if (!estimate.gamma) continue;
      const double off = *estimate.gamma - frame.gamma();
      ++answered;
      errors += std::fabs(off);
      within += std::fabs(off) < 2 * *estimate.sigma ? 1 : 0;
      // Torque within a taxel is not sensed: single answers are further off than on fine arrays.
      EXPECT_LT(off, 0.2) << "too safe, Gamma " << frame.gamma();
    }
  }
  EXPECT_GT(answered, 0.9 * frames);
  EXPECT_LT(errors / answered, 0.05);
  EXPECT_GT(within, 0.85 * answered);
}

}  // namespace
}  // namespace slipd
