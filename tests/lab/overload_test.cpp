// The frames that remain when frames are skipped, and the statistics of their estimates.
#include <gtest/gtest.h>

#include <cmath>

#include "core/contact/scene.hpp"
#include "lab/overload/report.hpp"

namespace lab {
namespace {

using slipd::RandomStream;

constexpr std::uint64_t kFrames = 200000;

// The number of frames that remain of kFrames, and the longest run of them.
struct Coming {
  std::uint64_t all = 0, longest_run = 0;
};

Coming count(Skipping skipping, unsigned k, std::uint64_t seed = 1) {
  const auto comes_now = comes(skipping, k, RandomStream(seed));
  Coming coming;
  std::uint64_t run = 0;
  for (std::uint64_t frame = 1; frame <= kFrames; ++frame) {
    run = comes_now(frame) ? run + 1 : 0;
    coming.all += run > 0 ? 1 : 0;
    coming.longest_run = std::max(coming.longest_run, run);
  }
  return coming;
}

TEST(Skipping, LetsOneFrameOfKComeHoweverTheyAreSpread) {
  for (const auto skipping : {Skipping::regular, Skipping::random, Skipping::bursts}) {
    EXPECT_EQ(count(skipping, 1).all, kFrames) << name_of(skipping);
    for (const unsigned k : {2, 5, 20})
      EXPECT_NEAR(static_cast<double>(count(skipping, k).all), kFrames / k, 0.2 * kFrames / k)
          << name_of(skipping) << " " << k;
  }
}

TEST(Skipping, ComesSinglyOrInRuns) {
  EXPECT_EQ(count(Skipping::regular, 5).longest_run, 1U);
  EXPECT_LT(count(Skipping::random, 20).longest_run, 10U);
  EXPECT_GT(count(Skipping::bursts, 20).longest_run, 50U);
}

TEST(Skipping, BeginsWithAFrameThatComesAndIsDrawnAgainByItsSeed) {
  for (const auto skipping : {Skipping::regular, Skipping::random, Skipping::bursts}) {
    EXPECT_TRUE(comes(skipping, 50, RandomStream(3))(1));
    EXPECT_EQ(count(skipping, 5, 3).all, count(skipping, 5, 3).all);
  }
  EXPECT_NE(count(Skipping::random, 5, 3).all, count(Skipping::random, 5, 4).all);
}

Estimator estimator() {
  slipd::ChainSetup setup{.layout = slipd::TaxelLayout::grid(16, 16, 0.001),
                          .scene = {},
                          .estimator = {.method = slipd::MethodChoice::moments},
                          .alerts = {},
                          .friction = {}};
  setup.scene.objects = slipd::paper_objects();
  setup.scene.offset_m = 0.002;
  setup.scene.noise = 0.01;
  return {setup, nullptr};
}

TEST(Overload, TalliesEachFrameThatComesAndTheBoardAtEachFrame) {
  const OverloadSetup setup{.grasps = 4, .sensing = {.frame_s = 0.001}, .seed = 1, .threads = 2};
  const auto all = measure_overload(estimator(), {Skipping::regular, 1}, setup);
  const auto some = measure_overload(estimator(), {Skipping::regular, 10}, setup);
  EXPECT_EQ(all.estimates.frames(), all.board.frames());
  EXPECT_NEAR(all.estimates.mean_error(), all.board.mean_error(), 1e-12)
      << "but for the order of the sum: where all come, the last one is the newest";
  EXPECT_EQ(some.board.frames(), all.board.frames());
  EXPECT_NEAR(some.estimates.frames(), all.estimates.frames() / 10, 0.01 * all.estimates.frames());
  const auto few = measure_overload(estimator(), {Skipping::regular, 50}, setup);
  EXPECT_GT(few.board.mean_error(), few.estimates.mean_error()) << "an old margin is further off";
}

TEST(Overload, IsTheSameWhateverTheThreads) {
  OverloadSetup setup{.grasps = 3, .sensing = {.frame_s = 0.002}, .seed = 2, .threads = 1};
  const auto once = measure_overload(estimator(), {Skipping::bursts, 5}, setup);
  setup.threads = 3;
  const auto again = measure_overload(estimator(), {Skipping::bursts, 5}, setup);
  EXPECT_EQ(once.estimates.frames(), again.estimates.frames());
  EXPECT_EQ(once.estimates.mean_error(), again.estimates.mean_error());
}

TEST(Overload, IsReportedLineByLine) {
  OverloadSetup setup{.grasps = 1, .sensing = {.frame_s = 0.005}, .seed = 1, .threads = 1};
  auto line = measure_overload(estimator(), {Skipping::random, 2}, setup);
  line.columns = 16;
  line.method = "moments";
  const auto json = offline::assembled(to_sweep({line}, setup));
  EXPECT_EQ(json["rows"].size(), 1U);
  EXPECT_EQ(json["rows"][0]["frames_come"], "random");
  EXPECT_EQ(json["rows"][0]["k"], 2);
  EXPECT_EQ(json["rows"][0]["estimates"]["frames"], line.estimates.frames());
  double states = 0;
  for (const auto& [name, share] : json["rows"][0]["estimates"]["states"].items())
    states += share.get<double>();
  EXPECT_NEAR(states, 1, 1e-9);
}

}  // namespace
}  // namespace lab
