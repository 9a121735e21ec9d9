// Fingers of a few flat pillars, whose margin is that of forces and of a friction that is known as a range:
// no alarm from a grip that nobody pulls at, no safe margin for what is no grip, and friction from slides
// only.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "core/chain/chain.hpp"

namespace slipd {
namespace {

constexpr double kFlatPitch_m = 0.007;
constexpr double kRate_hz = 500;
constexpr Range kPadFrictions{0.3, 1};

ChainSetup finger_setup() {
  ChainSetup setup{.layout = TaxelLayout::grid(3, 3, kFlatPitch_m),
                   .scene = {},
                   .estimator = {},
                   .alerts = {},
                   .friction = KnownFriction(kPadFrictions)};
  setup.scene.skin.radius_m = std::numeric_limits<double>::infinity();
  setup.scene.objects = paper_objects();
  return setup;
}

// What the pillars carry, N. Pillars of different heights share the load unevenly, and pressing alone makes a
// shear that points outwards.
struct PadLoad {
  double normal_n = 0;
  double pull_n = 0;   // along x, shared as the normal force
  double apart_n = 0;  // columns left and right pulled apart by that much each
  double texture = 0;  // phase of the object's surface over the pillars, rad
};

class Finger {
 public:
  explicit Finger(const ChainSetup& setup, std::uint64_t seed = 1) : chain_(setup, nullptr), random_(seed) {}

  Estimate sense(const PadLoad& load) {
    constexpr double kShares[9] = {0.08, 0.12, 0.09, 0.13, 0.16, 0.12, 0.1, 0.13, 0.07};
    constexpr double kOutward = 0.3;
    std::normal_distribution<double> noise(0, 0.004);
    double shares[9], sum = 0, middle_x = 0, middle_y = 0;
    for (std::size_t i = 0; i < 9; ++i)
      sum += shares[i] = kShares[i] * (1 + 0.4 * std::sin(load.texture + 2.3 * static_cast<double>(i)));
    for (std::size_t i = 0; i < 9; ++i) {
      shares[i] /= sum;
      middle_x += shares[i] * column_of(i);
      middle_y += shares[i] * row_of(i);
    }
    for (std::size_t i = 0; i < 9; ++i) {
      const double column = column_of(i) - middle_x, row = row_of(i) - middle_y;
      const double normal_n = load.normal_n * shares[i];
      const double x_n =
          kOutward * normal_n * column + load.pull_n * shares[i] + column_of(i) * load.apart_n / 3;
      set(p_, i, normal_n + noise(random_));
      set(x_, i, x_n + noise(random_));
      set(y_, i, kOutward * normal_n * row + noise(random_));
    }
    return estimate();
  }

  // Rows of a recording: x, y, z of each pillar, N.
  Estimate feel_row(const std::vector<double>& row) {
    for (std::size_t i = 0; i < 9; ++i) {
      set(x_, i, row[3 * i]);
      set(y_, i, row[3 * i + 1]);
      set(p_, i, row[3 * i + 2]);
    }
    return estimate();
  }

  // The same values again, as of a device that is asked more often than it measures.
  Estimate feel_again() { return estimate(); }
  bool repeats() const { return chain_.repeats(); }
  // Nothing is asked for the time of a frame.
  void pass() { ++sequence_; }

 private:
  static double column_of(std::size_t i) { return static_cast<double>(i % 3) - 1; }
  static double row_of(std::size_t i) { return std::floor(static_cast<double>(i) / 3) - 1; }
  void set(std::vector<float>& channel, std::size_t i, double force_n) const {
    channel[i] = static_cast<float>(force_n / (kFlatPitch_m * kFlatPitch_m));
  }
  Estimate estimate() {
    ++sequence_;
    return chain_.estimate(
        {.sequence = sequence_,
         .time_ns = static_cast<std::int64_t>(1e9 * static_cast<double>(sequence_) / kRate_hz),
         .normal_pa = p_,
         .shear_x_pa = x_,
         .shear_y_pa = y_,
         .zeroed = true});
  }

  EstimatorChain chain_;
  std::mt19937_64 random_;
  std::vector<float> p_ = std::vector<float>(9), x_ = p_, y_ = p_;
  std::uint64_t sequence_ = 0;
};

// The gripper comes, overshoots 3.6 times and relaxes; nobody pulls, |Q|/P is even.
double gripped_n(double time_s) {
  if (time_s < 0.5) return 0;
  if (time_s < 0.7) return 18 * (time_s - 0.5) / 0.2;
  return 5 + 13 * std::exp(-(time_s - 0.7) / 0.1);
}

int frames_of(double seconds) {
  return static_cast<int>(seconds * kRate_hz);
}

double time_of(int frame) {
  return frame / kRate_hz;
}

TEST(FlatPads, AGripThatOvershootsRaisesNoAlertAndHasAMarginWhileItHolds) {
  for (const double load : {0.02, 0.1, 0.19}) {
    Finger finger(finger_setup());
    int held = 0, ok = 0;
    for (int i = 0; i < frames_of(4); ++i) {
      const double normal_n = gripped_n(time_of(i));
      const Estimate said = finger.sense({.normal_n = normal_n, .pull_n = load * normal_n});
      EXPECT_NE(said.alert, Alert::slip) << load << " at " << time_of(i);
      EXPECT_FALSE(said.friction) << "nothing slid";
      if (time_of(i) < 1) continue;
      ++held;
      if (said.state != State::ok) continue;
      ++ok;
      // Sigma covers both ends of what friction may be.
      for (const double friction : {kPadFrictions.low, kPadFrictions.high})
        EXPECT_LT(std::fabs(1 - load / friction - *said.gamma), 3 * *said.sigma) << load;
    }
    EXPECT_GT(ok, 0.95 * held) << load;
  }
}

// The same frames at the same times, once with each frame three times more in between.
TEST(FlatPads, LearnNothingFromAFrameThatIsTheOneBefore) {
  constexpr int kMore = 3;
  Finger once(finger_setup()), often(finger_setup());
  int told = 0;
  for (int i = 0; i < 1200; ++i) {
    const double time_s = (kMore + 1) * i / kRate_hz;
    const PadLoad load{.normal_n = gripped_n(time_s), .pull_n = std::max(0.0, time_s - 4)};
    const Estimate expected = once.sense(load);
    for (int k = 0; k < kMore; ++k) once.pass();
    const Estimate first = often.sense(load);
    ASSERT_EQ(first.state, expected.state) << i;
    ASSERT_EQ(first.gamma, expected.gamma) << i;
    ASSERT_EQ(first.sigma, expected.sigma) << i;
    ASSERT_EQ(first.friction, expected.friction) << i;
    ASSERT_EQ(first.sliding, expected.sliding) << i;
    for (int k = 0; k < kMore; ++k) {
      const Estimate again = often.feel_again();
      ASSERT_TRUE(often.repeats());
      ASSERT_GT(again.time_ns, first.time_ns);
      ASSERT_GT(again.sequence, first.sequence);
      ASSERT_EQ(again.gamma, first.gamma) << i;
      ASSERT_EQ(again.sigma, first.sigma) << i;
    }
    told += first.gamma ? 1 : 0;
  }
  EXPECT_GT(told, 600);
}

TEST(FlatPads, RepeatsOfOneGraspHaveTheSameMargin) {
  std::vector<double> margins;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Finger finger(finger_setup(), seed);
    Estimate said;
    for (int i = 0; i < frames_of(3); ++i) {
      const double normal_n = gripped_n(time_of(i));
      said = finger.sense({.normal_n = normal_n, .pull_n = 0.1 * normal_n});
    }
    margins.push_back(said.gamma.value());
  }
  const auto [least, most] = std::minmax_element(margins.begin(), margins.end());
  EXPECT_LT(*most - *least, 0.02);
}

TEST(FlatPads, ThatNothingTouchesRaiseNoAlertWhileTheirZeroWanders) {
  Finger finger(finger_setup());
  for (int i = 0; i < frames_of(20); ++i) {
    const double wander = std::sin(0.5 * time_of(i));
    const Estimate said = finger.sense({.normal_n = 0.08 * wander, .pull_n = 0.1 * wander});
    ASSERT_EQ(said.alert, Alert::none) << time_of(i);
    ASSERT_EQ(said.state, State::no_contact) << time_of(i);
  }
}

// Pillars that hook: pressure falls while shear grows, and pillars carry against each other.
TEST(FlatPads, ThatArePulledApartHaveNoSafeMarginAndAreInContact) {
  for (const double last_n : {0.02, 0.5, 4.0}) {
    Finger finger(finger_setup());
    for (int i = 0; i < frames_of(2); ++i) finger.sense({.normal_n = gripped_n(time_of(i))});
    for (int i = 0; i < frames_of(2); ++i) {
      const double part = time_of(i) / 2;
      const Estimate said =
          finger.sense({.normal_n = 5 + part * (last_n - 5), .pull_n = 2 * part, .apart_n = 4 * part});
      EXPECT_NE(said.state, State::no_contact) << time_of(i);
      if (part > 0.25) {
        EXPECT_LT(said.gamma.value_or(0), 0.4) << time_of(i);
        EXPECT_LT(said.gamma_low.value_or(0), 0.2) << time_of(i);
      }
    }
  }
}

// A cable that hooks on the pillars is pulled at with several times what any friction holds, and comes off.
TEST(FlatPads, LearnNoFrictionFromAHook) {
  Finger finger(finger_setup());
  for (int i = 0; i < frames_of(1.5); ++i) finger.sense({.normal_n = gripped_n(time_of(i))});
  constexpr double kHooked = 4, kAfter = 0.16;
  Estimate said;
  const auto pull_n = [](double load) { return PadLoad{.normal_n = 2.5, .pull_n = 2.5 * load}; };
  for (int i = 0; i < frames_of(1); ++i) said = finger.sense(pull_n(kHooked * time_of(i)));
  EXPECT_EQ(said.gamma.value_or(0), 0);
  for (int i = 0; i < frames_of(0.7); ++i) {
    const double load = std::max(kAfter, kHooked * (1 - 5 * time_of(i)));
    said = finger.sense(pull_n(load));
    EXPECT_FALSE(said.friction) << load;
    EXPECT_LE(said.gamma.value_or(0), std::max(0.0, 1 - load / 0.55) + 0.1) << load;
  }
  EXPECT_LE(said.gamma_low.value(), 1 - 0.16 / kPadFrictions.low);
}

TEST(FlatPads, LearnFrictionFromASlideWithinTheRangeAndKnowItAfterwards) {
  for (const double friction : {0.35, 0.6, 0.9}) {
    Finger finger(finger_setup());
    std::mt19937_64 random(7);
    std::normal_distribution<double> scatter(0, 0.05);
    Estimate said;
    for (int i = 0; i < frames_of(2); ++i)
      said = finger.sense({.normal_n = gripped_n(time_of(i)), .pull_n = 0.05 * gripped_n(time_of(i))});
    EXPECT_FALSE(said.friction);
    bool alerted = false;
    double rough = 0;
    for (int i = 0; i < frames_of(2); ++i) {  // the load rises for half a second, then it slides
      const double load = std::min(friction, 0.05 + 2 * (friction - 0.05) * time_of(i));
      if (i % 10 == 0) rough = load < friction ? 0 : scatter(random);
      const double slid_s = std::max(0.0, time_of(i) - 0.5);
      said = finger.sense({.normal_n = 5, .pull_n = 5 * load * (1 + rough), .texture = 3 * slid_s});
      alerted = alerted || said.alert == Alert::slip;
    }
    EXPECT_TRUE(alerted);
    for (int i = 0; i < frames_of(1); ++i) {  // set down within half a second
      const double pull_n = 1.2 + (5 * friction - 1.2) * std::max(0.0, 1 - 2 * time_of(i));
      said = finger.sense({.normal_n = 5, .pull_n = pull_n, .texture = 4.5});
    }
    ASSERT_TRUE(said.friction) << friction;
    EXPECT_NEAR(*said.friction, friction, 0.07 * friction);
    EXPECT_LE(*said.friction, kPadFrictions.high);
    EXPECT_GE(*said.friction, kPadFrictions.low);
  }
}

TEST(FlatPads, GiveASafeMarginBeforeFrictionIsKnown) {
  ChainSetup setup = finger_setup();
  setup.friction = KnownFriction(Range{0.1, 1});
  Finger finger(setup);
  Estimate said;
  for (int i = 0; i < frames_of(3); ++i) said = finger.sense({.normal_n = 5, .pull_n = 0.35});
  EXPECT_EQ(said.state, State::learning);
  EXPECT_FALSE(said.gamma);
  EXPECT_NEAR(said.gamma_low.value(), 1 - 0.07 / 0.1, 0.05);
}

TEST(FlatPads, AnswerUnderASkinAsWithoutOne) {
  ChainSetup setup = finger_setup();
  Finger bare(setup);
  setup.scene.skin.depth_m = 0.0025;
  Finger covered(setup);
  int answered = 0;
  for (int i = 0; i < frames_of(2); ++i) {
    const double normal_n = gripped_n(time_of(i));
    const PadLoad load{.normal_n = normal_n, .pull_n = 0.1 * normal_n};
    const Estimate without = bare.sense(load), with = covered.sense(load);
    ASSERT_EQ(with.state, without.state) << time_of(i);
    ASSERT_EQ(with.gamma, without.gamma) << time_of(i);
    ASSERT_EQ(with.gamma_low, without.gamma_low) << time_of(i);
    answered += with.gamma ? 1 : 0;
  }
  EXPECT_GT(answered, 0.6 * frames_of(2));
}

// Whatever friction is within its range, the margin is small: told on the safe side.
TEST(FlatPads, HaveALowMarginWhereTheRangeAloneLeavesItNearZero) {
  for (const double load : {0.52, 0.6, 0.8}) {
    Finger finger(finger_setup());
    Estimate said;
    for (int i = 0; i < frames_of(2); ++i) {
      const double pulled = std::clamp(2 * (time_of(i) - 1.5), 0.0, 1.0);
      said =
          finger.sense({.normal_n = gripped_n(time_of(i)), .pull_n = pulled * load * gripped_n(time_of(i))});
      if (said.state == State::ok && pulled * load > kPadFrictions.low) {
        EXPECT_LT(*said.gamma, 0.25) << pulled * load;
      }
    }
    ASSERT_EQ(said.state, State::ok) << load;
    EXPECT_TRUE(is_raised(said.alert)) << load;
  }
}

// A pillar that hardly touches amid the others is no dead taxel that neighbours would stand for.
TEST(FlatPads, FeelWhatTheirPillarsFeelAlsoInAHollow) {
  for (const double hollow_n : {0.3, 0.03, 0.0}) {
    Finger finger(finger_setup());
    Estimate said;
    for (int i = 0; i < frames_of(2); ++i) {
      std::vector<double> row;
      for (std::size_t taxel = 0; taxel < 9; ++taxel) {
        const double normal_n = time_of(i) < 0.5 ? 0 : taxel == 4 ? hollow_n : 0.6;
        row.insert(row.end(), {0.1 * normal_n, 0.0, normal_n});
      }
      said = finger.feel_row(row);
    }
    EXPECT_NEAR(said.normal_n.value(), 8 * 0.6 + hollow_n, 1e-3) << hollow_n;
    EXPECT_NEAR(said.shear_n.value(), 0.1 * (8 * 0.6 + hollow_n), 1e-3) << hollow_n;
  }
}

TEST(FlatPads, AlertByTheSafeMarginWhereThatIsWanted) {
  ChainSetup setup = finger_setup();
  setup.friction = KnownFriction(Range{0.1, 1});
  for (const AlertUse use : {AlertUse::margin, AlertUse::low}) {
    setup.alerts.use = use;
    Finger finger(setup);
    Estimate said;
    for (int i = 0; i < frames_of(2); ++i) said = finger.sense({.normal_n = 5, .pull_n = 0.45});
    EXPECT_EQ(said.state, State::learning);
    EXPECT_EQ(said.alert, use == AlertUse::low ? Alert::slip : Alert::none);
  }
}

TEST(FlatPads, WithAGivenFrictionGiveItAndNoOther) {
  ChainSetup setup = finger_setup();
  setup.friction = 0.38;
  Finger finger(setup);
  for (int i = 0; i < frames_of(3); ++i) {
    const double normal_n = gripped_n(time_of(i));
    const Estimate said = finger.sense({.normal_n = normal_n, .pull_n = 0.09 * normal_n});
    if (time_of(i) < 1) continue;
    EXPECT_DOUBLE_EQ(said.friction.value(), 0.38);
    EXPECT_NEAR(said.gamma.value(), 1 - 0.09 / 0.38, 0.04);
  }
}

std::filesystem::path recorded_pillars() {
  const char* given = std::getenv("SLIPD_SHARED");
  const std::filesystem::path shared = given != nullptr
                                           ? std::filesystem::path(given)
                                           : std::filesystem::path(SLIPD_SOURCE_DIR) / ".." / "shared";
  return shared / "data" / "pillars";
}

// The margins of the middle of the hold, and |Q|/P there.
struct Hold {
  double margin = 0, load = 0;
  std::size_t frames = 0, ok = 0;
  bool slip = false;
};

Hold held(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  Finger finger(finger_setup());
  std::vector<Estimate> said;
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    std::vector<double> row;
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
    row.erase(row.begin());  // time
    said.push_back(finger.feel_row(row));
  }
  std::vector<double> margins, loads;
  Hold hold;
  for (std::size_t i = said.size() / 2 - said.size() / 8; i < said.size() / 2 + said.size() / 8; ++i) {
    const Estimate& each = said[i];
    ++hold.frames;
    hold.slip = hold.slip || each.alert == Alert::slip;
    if (!each.gamma) continue;
    ++hold.ok;
    margins.push_back(*each.gamma);
    loads.push_back(*each.shear_n / *each.normal_n);
  }
  if (margins.empty()) return hold;
  const auto middle_of = [](std::vector<double>& values) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                     values.end());
    return values[values.size() / 2];
  };
  hold.margin = middle_of(margins);
  hold.load = middle_of(loads);
  return hold;
}

TEST(RecordedPillars, ThatNobodyPullsAtHaveAMarginThatTheirForcesExplain) {
  const auto folder = recorded_pillars();
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "needs ../shared/data/pillars";
  std::size_t frames = 0, ok = 0, slips = 0;
  // Of the range, log even: 1 - load <1/mu>, lowered by at most a sigma.
  const double width = std::log(kPadFrictions.high / kPadFrictions.low);
  const double inverse = (1 / kPadFrictions.low - 1 / kPadFrictions.high) / width;
  const double square =
      (1 / (kPadFrictions.low * kPadFrictions.low) - 1 / (kPadFrictions.high * kPadFrictions.high)) /
      (2 * width);
  const double spread = std::sqrt(square - inverse * inverse);
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (!file.path().filename().string().starts_with("grasp_release")) continue;
    const Hold hold = held(file.path());
    frames += hold.frames;
    ok += hold.ok;
    slips += hold.slip ? 1 : 0;
    if (hold.ok == 0) continue;
    const double sigma = spread * hold.load;
    const double most = EstimatorSettings{}.sigma_max;
    const double down = std::min(sigma, std::sqrt(std::max(0.0, most * most - sigma * sigma)));
    EXPECT_NEAR(hold.margin, 1 - inverse * hold.load - down, 0.05) << file.path().filename();
  }
  EXPECT_GE(static_cast<double>(ok), 0.95 * static_cast<double>(frames));
  EXPECT_EQ(slips, 0U);
}

// Counts that were shifted since the zero was taken: 20 N of shear before anything touches the finger.
TEST(FlatPads, HaveNoMarginAndNoAlarmWithAZeroThatIsAnothers) {
  Finger finger(finger_setup());
  for (int i = 0; i < 1000; ++i) {
    const Estimate now = finger.sense({.normal_n = i < 300 ? 0.0 : 6.0, .pull_n = 20});
    ASSERT_EQ(now.state, State::unzeroed) << i;
    ASSERT_FALSE(now.gamma || now.gamma_low);
    ASSERT_NE(now.alert, Alert::slip);
  }
}

}  // namespace
}  // namespace slipd
