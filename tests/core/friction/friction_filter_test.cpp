// The friction filter over whole grasps: the state of the load history, the friction that it learns, and
// recovery from errors in both.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>

#include "core/friction/by_forces.hpp"
#include "core/friction/by_shape.hpp"
#include "core/health/usual.hpp"
#include "core/numeric/random.hpp"
#include "core/reading/moments/moments.hpp"
#include "tests/core/friction/followed_filter.hpp"
#include "tests/support/heap_count.hpp"
#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

using friction_filter::Followed;
using friction_filter::forces;
using friction_filter::kFilterPrior;
using synthetic::FrameMaker;

using ByShape = Followed<FrictionByShape>;
using ByForces = Followed<FrictionByForces>;

// One contact on 50 x 50 taxels, estimated by moments, a frame each millisecond.
class Grasp {
 public:
  explicit Grasp(const FrictionFilterOptions& options = {}) : filter(kFilterPrior, options) {}

  // Moves linearly to the given forces in `frames` frames; `seen` false: the filter gets none of them.
  void move(double normal_n, double shear_n, double friction, int frames, bool seen = true) {
    const double from_normal_n = contact_.normal_n(), from_shear_n = contact_.shear_n();
    for (int i = 1; i <= frames; ++i) {
      const double part = static_cast<double>(i) / frames;
      contact_.move_to(from_normal_n + part * (normal_n - from_normal_n),
                       from_shear_n + part * (shear_n - from_shear_n), friction);
      if (seen) see();
    }
  }

  void see() {
    const Frame frame = maker_.make(contact_, 0, 0, direction_rad, 0.01);
    const ContactPatch& patch = finder_.find(frame);
    const Reading estimate = method_.estimate(frame, patch);
    filter.update(frame.time_ns, patch, &estimate);
    if (each_frame) each_frame();
  }

  double margin() const { return contact_.safety_margin(); }

  ByShape filter;
  double direction_rad = 0.3;
  std::function<void()> each_frame;

 private:
  FrameMaker maker_{TaxelLayout::grid(50, 50, 0.00029)};
  PatchFinder finder_{maker_.layout()};
  Moments method_{maker_.layout()};
  contact::LoadHistory contact_{synthetic::paper_pair()};
};

// A method's estimate.
Reading monotonic_frame(double gamma) {
  Reading estimate;
  estimate.in_model = true;
  estimate.gamma = gamma;
  estimate.sigma = 0.01;
  return estimate;
}

TEST(FrictionFilter, AGraspThatIsSeenFromItsBeginHasAMonotonicHistory) {
  Grasp grasp;
  grasp.move(2, 0, 0.5, 50);
  grasp.move(2, 0.8, 0.5, 100);
  EXPECT_EQ(grasp.filter->history(), HistoryState::monotonic);
  EXPECT_TRUE(grasp.filter->understood());
  EXPECT_NEAR(grasp.filter->grid().friction().mean, 0.5, 0.02);
}

TEST(FrictionFilter, ARegripLeavesAGeneralHistoryAndLoadBeyondItAMonotonicOne) {
  Grasp grasp;
  grasp.move(2, 0, 0.5, 50);
  grasp.move(2, 0.8, 0.5, 100);
  grasp.move(3, 0.8, 0.5, 50);
  EXPECT_EQ(grasp.filter->history(), HistoryState::general);
  EXPECT_TRUE(grasp.filter->understood());
  grasp.move(3, 1.45, 0.5, 150);
  EXPECT_EQ(grasp.filter->history(), HistoryState::monotonic);
}

TEST(FrictionFilter, UnloadingAndReversalAreAGeneralHistoryInWhichFrictionStaysKnown) {
  Grasp grasp;
  grasp.move(2, 0, 0.5, 50);
  grasp.move(2, 0.8, 0.5, 100);
  grasp.move(2, -0.5, 0.5, 150);
  EXPECT_EQ(grasp.filter->history(), HistoryState::general);
  EXPECT_TRUE(grasp.filter->understood());
  EXPECT_NEAR(grasp.filter->grid().friction().mean, 0.5, 0.05);
}

TEST(FrictionFilter, AGraspMetUnderLoadHasNoMarginUntilFramesConfirmItsHistory) {
  Grasp grasp;
  grasp.move(2, 0, 0.5, 50, false);
  grasp.move(2, 0.6, 0.5, 50, false);
  const FrictionFilterOptions options;
  std::uint32_t frames = 0;
  grasp.each_frame = [&] {
    ++frames;
    if (frames < kSureFrames) return;
    const bool confirmed = frames >= kSureFrames + options.history.confirming_frames - 1;
    EXPECT_EQ(grasp.filter->understood(), confirmed) << "frame " << frames;
    EXPECT_EQ(grasp.filter->history(), confirmed ? HistoryState::monotonic : HistoryState::assumed_monotonic);
  };
  grasp.move(2, 0.7, 0.5, 40);
  EXPECT_NEAR(grasp.filter->grid().friction().mean, 0.5, 0.02);
}

TEST(FrictionFilter, AGraspMetUnderLoadThatIsUnloadedStaysUnknown) {
  Grasp grasp;
  grasp.move(2, 0, 0.5, 50, false);
  grasp.move(2, 0.8, 0.5, 50, false);
  grasp.move(2, 0.8, 0.5, 10);
  EXPECT_EQ(grasp.filter->history(), HistoryState::assumed_monotonic);
  grasp.move(2, 0.2, 0.5, 60);
  EXPECT_EQ(grasp.filter->history(), HistoryState::unknown);
  EXPECT_FALSE(grasp.filter->understood());
}

TEST(FrictionFilter, ShearThatTurnsLosesTheHistoryAndItIsConfirmedAgain) {
  Grasp grasp;
  grasp.move(2, 0, 0.5, 50);
  grasp.move(2, 0.6, 0.5, 60);
  EXPECT_TRUE(grasp.filter->understood());
  grasp.direction_rad += 1.2;
  grasp.see();
  EXPECT_EQ(grasp.filter->history(), HistoryState::assumed_monotonic);
  EXPECT_FALSE(grasp.filter->understood());
  grasp.move(2, 0.7, 0.5, 40);
  EXPECT_EQ(grasp.filter->history(), HistoryState::monotonic);
  EXPECT_TRUE(grasp.filter->understood());
}

// A grip at 60 Hz that grows by a fifth in five frames, as one that begins would.
TEST(FrictionFilter, AContactThatWasOutOfSightHasNoKnownHistoryHoweverItsForceGrows) {
  ByShape filter(kFilterPrior);
  std::int64_t time_ns = 0;
  filter.update(time_ns += 16'000'000, forces(2, 0), nullptr);
  ASSERT_EQ(filter->history(), HistoryState::monotonic);
  filter->lose_sight();
  for (int i = 0; i < 6; ++i) {
    filter.update(time_ns += 16'000'000, forces(2 * (1 + 0.05 * i), 0.8), nullptr);
    EXPECT_FALSE(is_known(filter->history())) << i;
  }
  filter.reset();
  filter.update(time_ns += 16'000'000, forces(0.1, 0), nullptr);
  EXPECT_EQ(filter->history(), HistoryState::monotonic) << "a new grasp is seen from its begin";
}

TEST(FrictionFilter, ARunOfFramesThatNoFrictionExplainsLosesTheHistoryAndFramesBringItBack) {
  ByForces filter(kFilterPrior);
  std::int64_t time_ns = 0;
  const auto see = [&](double gamma) {
    const Reading estimate = monotonic_frame(gamma);
    filter.update(time_ns += 1'000'000, forces(2, 0.5), &estimate);
  };
  for (int i = 0; i < 10; ++i) see(0.5);
  EXPECT_TRUE(filter->understood());
  const FrictionFilterOptions options;
  for (std::uint32_t i = 1; i <= kSureFrames; ++i) {
    EXPECT_EQ(filter->history(), HistoryState::monotonic) << "before outlier " << i;
    see(9);
  }
  EXPECT_EQ(filter->history(), HistoryState::assumed_monotonic);
  EXPECT_FALSE(filter->understood());
  int frames = 0;
  while (!filter->understood() && frames < 200) {
    see(0.5);
    ++frames;
  }
  EXPECT_GE(frames, options.history.confirming_frames);
  EXPECT_LT(frames, 3 * options.history.confirming_frames);
  EXPECT_NEAR(filter->grid().friction().mean, 0.5, 0.05);
}

// Such frames fit any history.
TEST(FrictionFilter, FramesThatLeaveTheMarginOpenConfirmNoHistory) {
  ByShape filter(kFilterPrior);
  Reading estimate = monotonic_frame(0.4);
  std::int64_t time_ns = 0;
  const auto see = [&](double sigma) {
    estimate.sigma = sigma;
    for (int i = 0; i < 100; ++i) filter.update(time_ns += 1'000'000, forces(2, 0.5), &estimate);
  };
  see(0.25);  // from its first frame on loaded, and so assumed monotonic
  EXPECT_EQ(filter->history(), HistoryState::assumed_monotonic);
  see(0.05);
  EXPECT_EQ(filter->history(), HistoryState::monotonic);
}

TEST(FrictionFilter, SingleOutliersDoNotChangeTheWeights) {
  ByForces filter(kFilterPrior);
  std::int64_t time_ns = 0;
  for (int i = 0; i < 100; ++i) {
    const Reading estimate = monotonic_frame(i % 4 == 3 ? 9 : 0.5);
    filter.update(time_ns += 1'000'000, forces(2, 0.5), &estimate);
  }
  EXPECT_EQ(filter->history(), HistoryState::monotonic);
  EXPECT_NEAR(filter->grid().friction().mean, 0.5, 0.05);
}

// Methods read their sigmas from the same noisy frame: one that shows less margin than there is has the
// smaller share in common with others.
TEST(FrictionFilter, NoisyFramesOfALightLoadGiveTheRightFrictionInTheMean) {
  constexpr double kFriction = 0.5, kNormal_n = 2, kSigma = 0.1;
  constexpr int kGrasps = 60, kFrames = 150;
  double sum_of_logs = 0;
  for (std::uint64_t grasp = 0; grasp < kGrasps; ++grasp) {
    const RandomStream random(grasp);
    ByShape filter(kFilterPrior);
    std::int64_t time_ns = 0;
    for (int i = 0; i < kFrames; ++i) {
      const double utilisation = 0.5 * i / kFrames;
      Reading frame = monotonic_frame(std::clamp(
          1 - utilisation + std::sqrt(3) * kSigma * random.uniform(static_cast<std::uint64_t>(i), -1, 1), 0.0,
          1.0));
      frame.sigma = kSigma;
      frame.common_sigma = 0.005 + 0.045 * frame.gamma;
      filter.update(time_ns += 1'000'000, forces(kNormal_n, utilisation * kFriction * kNormal_n), &frame);
    }
    sum_of_logs += std::log(filter->grid().friction().mean / kFriction);
  }
  EXPECT_NEAR(sum_of_logs / kGrasps, 0, 0.03);
}

TEST(FrictionFilter, FrictionThatFellIsLearntWithinAFewFrames) {
  Grasp grasp;
  grasp.move(2, 0, 0.6, 50);
  grasp.move(2, 0.6, 0.6, 100);
  EXPECT_NEAR(grasp.filter->grid().friction().mean, 0.6, 0.03);
  grasp.move(2, 0.6, 0.4, 1);
  grasp.move(2, 0.62, 0.4, 40);
  EXPECT_NEAR(grasp.filter->grid().friction().mean, 0.4, 0.05);
}

TEST(FrictionFilter, FrictionThatRoseIsLearntOnceTheLoadGrows) {
  Grasp grasp;
  grasp.move(2, 0, 0.4, 50);
  grasp.move(2, 0.6, 0.4, 100);
  grasp.move(2, 1.1, 0.7, 200);
  EXPECT_NEAR(grasp.filter->grid().friction().mean, 0.7, 0.07);
}

// 16 % of the friction limit within a millisecond is more than a gripper lets go.
TEST(FrictionFilter, ALoadThatIsLostAtOnceWasLostToSlidingAndOneThatFallsSlowlyWasLetGo) {
  const auto friction_after = [](std::int64_t drop_ns) {
    ByShape filter(kFilterPrior);
    std::int64_t time_ns = 0;
    for (int i = 1; i <= 100; ++i) {
      const Reading reading = monotonic_frame(1 - 0.004 * i / 0.5);
      filter.update(time_ns += 1'000'000, forces(2, 2 * 0.004 * i), &reading);
    }
    EXPECT_NEAR(filter->grid().friction().mean, 0.5, 0.02);
    filter.update(time_ns += drop_ns, forces(2, 2 * 0.32), nullptr);
    return filter->grid().friction().mean;
  };
  EXPECT_NEAR(friction_after(1'000'000), 0.32, 0.02);
  EXPECT_NEAR(friction_after(50'000'000), 0.5, 0.02);
}

// The slip moment of a load that is going back is against the shear, also where it is as large.
TEST(FrictionFilter, ALoadThatGoesBackIsNoMonotonicOneUntilItIsAsLargeAsBefore) {
  Grasp grasp;
  grasp.move(2, 0, 0.5, 50);
  grasp.move(2, 0.8, 0.5, 100);
  grasp.move(2, 0.7, 0.5, 20);
  int monotonic = 0;
  grasp.each_frame = [&] { monotonic += grasp.filter->history() == HistoryState::monotonic ? 1 : 0; };
  grasp.move(2, -0.5, 0.5, 240);
  EXPECT_EQ(monotonic, 0);
  grasp.move(2, -0.9, 0.5, 80);
  EXPECT_GT(monotonic, 0);
}

// Of many frames the noisiest would decide.
TEST(FrictionFilter, NoiseOfALongSlideRefutesNoFriction) {
  constexpr double kLoad = 0.3, kNoise = 0.01;
  ByShape filter(kFilterPrior);
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0, kNoise);
  std::int64_t time_ns = 0;
  for (int i = 0; i < 2000; ++i) {
    ContactPatch patch = forces(2, 2 * (kLoad + noise(random)));
    patch.shear_sigma_n = 2 * kNoise;
    filter.update(time_ns += 1'000'000, patch, nullptr);
  }
  const FrictionGrid& grid = filter->grid();
  std::size_t nearest = 0;
  for (std::size_t j = 0; j < grid.count(); ++j)
    if (std::fabs(grid.friction(j) - kLoad) < std::fabs(grid.friction(nearest) - kLoad)) nearest = j;
  EXPECT_GT(grid.weight(nearest), 0.5 * grid.weight(nearest + 4));
}

TEST(FrictionFilter, ANewGraspKnowsNothingOfTheOneBefore) {
  Grasp used, fresh;
  used.move(2, 0, 0.5, 30);
  used.move(2, 0.8, 0.5, 30);
  used.move(2, -0.4, 0.5, 30);
  used.filter.reset();
  EXPECT_EQ(used.filter->history(), HistoryState::monotonic);
  EXPECT_TRUE(used.filter->understood());
  EXPECT_EQ(used.filter->grid().friction().mean, fresh.filter->grid().friction().mean);
  EXPECT_EQ(used.filter->traction_ratio().mean, 0);
}

TEST(FrictionFilter, AllocatesNothing) {
  Grasp grasp;
  std::int64_t time_ns = 0;
  const Reading estimate = monotonic_frame(0.5);
  const auto before = test::allocations();
  for (int i = 1; i <= 100; ++i) {
    grasp.filter.update(time_ns += 1'000'000, forces(2, 0.01 * i), &estimate);
    if (i % 30 == 0) grasp.filter.reset();
  }
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace slipd
