// A device that breaks in mid-grasp never comes out as a safe grip, and a sound one is never called broken.
#include "core/health/plausibility.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "core/chain/chain.hpp"
#include "tests/support/heap_count.hpp"
#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

constexpr double kGripFriction = 0.5, kNormal_n = 3;
constexpr double kGross = 0.2;  // an error of the margin that lets objects fall
constexpr float kClip_pa = 5e3F;
constexpr int kGraceFrames = 5;  // after the fault began

struct Case {
  std::size_t side;
  MethodChoice method;
  synthetic::Noise noise;
};

// Frames of one grasp at 1 kHz, each of which may be spoilt before the chain gets it.
class GraspWithFault {
 public:
  explicit GraspWithFault(const Case& of)
      : setup_{.layout = TaxelLayout::grid(of.side, of.side,
                                           of.side == 4 ? 4.7e-3 : 16e-3 / static_cast<double>(of.side)),
               .scene = {},
               .estimator = {.method = of.method},
               .alerts = {},
               .friction = {}},
        noise_(of.noise),
        chain_(with_objects(setup_), nullptr),
        maker_(setup_.layout) {}

  using Spoil = std::function<void(FrameSlot&)>;

  // To the forces within so many frames; returns what the chain says of each.
  std::vector<Estimate> go(int frames, double normal_n, double shear_n, const Spoil& spoil = {}) {
    std::vector<Estimate> estimates;
    const double from_normal_n = contact_.normal_n(), from_shear_n = contact_.shear_n();
    for (int i = 1; i <= frames; ++i) {
      const double part = static_cast<double>(i) / frames;
      contact_.move_to(from_normal_n + part * (normal_n - from_normal_n),
                       from_shear_n + part * (shear_n - from_shear_n), kGripFriction);
      const Frame frame = maker_.make(contact_, 0.2e-3, -0.1e-3, 0.3, 0.01, noise_);
      x_.assign(frame.shear_x_pa.begin(), frame.shear_x_pa.end());
      y_.assign(frame.shear_y_pa.begin(), frame.shear_y_pa.end());
      p_.assign(frame.normal_pa.begin(), frame.normal_pa.end());
      FrameSlot slot;
      slot.sequence = frame.sequence;
      slot.time_ns = frame.time_ns;
      slot.normal_pa = p_;
      slot.shear_x_pa = x_;
      slot.shear_y_pa = y_;
      if (spoil) spoil(slot);
      estimates.push_back(chain_.estimate(slot.view()));
    }
    return estimates;
  }

  double margin() const { return contact_.safety_margin(); }

  // Grips and loads to 0.6 of what friction holds, and stays there.
  void load() {
    for (const auto& phase :
         {go(80, kNormal_n, 0), go(120, kNormal_n, kLoaded_n), go(60, kNormal_n, kLoaded_n)}) {
      for (const Estimate& at : phase) {
        ASSERT_EQ(at.health, Health::good) << to_string(at.health) << " of frame " << at.sequence;
        last_ = at;
      }
    }
  }
  const Estimate& last() const { return last_; }

  static constexpr double kLoaded_n = 0.6 * kGripFriction * kNormal_n;

 private:
  static const ChainSetup& with_objects(ChainSetup& setup) {
    setup.scene.objects = paper_objects();
    return setup;
  }
  ChainSetup setup_;
  synthetic::Noise noise_;
  EstimatorChain chain_;
  synthetic::FrameMaker maker_;
  contact::LoadHistory contact_{synthetic::paper_pair()};
  std::vector<float> p_, x_, y_;
  Estimate last_;
};

class Faults : public ::testing::TestWithParam<Case> {
 protected:
  // No margin is far above the truth, and the fault is named.
  static void expect_reported(GraspWithFault& grasp, const GraspWithFault::Spoil& spoil,
                              std::initializer_list<Health> names) {
    grasp.load();
    if (HasFatalFailure()) return;
    constexpr int kFrames = 100;
    const double before = grasp.margin();
    const auto estimates = grasp.go(kFrames, kNormal_n, 1.2 * GraspWithFault::kLoaded_n, spoil);
    const double after = grasp.margin();
    std::string seen;
    bool named = false;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
      const bool known = std::find(names.begin(), names.end(), estimates[i].health) != names.end();
      named = named || known;
      if (i < 30)
        seen += std::string(to_string(estimates[i].state)) + "/" +
                std::string(to_string(estimates[i].health)) + " ";
      const double truth = before + (after - before) * static_cast<double>(i + 1) / kFrames;
      if (i >= kGraceFrames && estimates[i].state == State::ok) {
        EXPECT_LT(*estimates[i].gamma, truth + kGross) << "frame " << i;
        if (*estimates[i].gamma >= truth + kGross) break;
      }
    }
    EXPECT_TRUE(named) << seen;
  }

  GraspWithFault grasp_{GetParam()};
};

void zero(std::span<float> values) {
  std::fill(values.begin(), values.end(), 0.0F);
}

TEST_P(Faults, AShearChannelThatDiesIsAFaultAndNoMargin) {
  expect_reported(grasp_, [](FrameSlot& f) { zero(f.shear_x_pa); }, {Health::dead_shear_x});
}

TEST_P(Faults, BothShearChannelsThatDieAreAFaultAndNoMargin) {
  expect_reported(grasp_,
                  [](FrameSlot& f) {
                    zero(f.shear_x_pa);
                    zero(f.shear_y_pa);
                  },
                  {Health::dead_shear_x, Health::dead_shear_y});
}

TEST_P(Faults, FrozenFramesAreAFault) {
  std::vector<float> p, x, y;
  expect_reported(grasp_,
                  [&](FrameSlot& f) {
                    if (p.empty()) {
                      p.assign(f.normal_pa.begin(), f.normal_pa.end());
                      x.assign(f.shear_x_pa.begin(), f.shear_x_pa.end());
                      y.assign(f.shear_y_pa.begin(), f.shear_y_pa.end());
                    }
                    std::copy(p.begin(), p.end(), f.normal_pa.begin());
                    std::copy(x.begin(), x.end(), f.shear_x_pa.begin());
                    std::copy(y.begin(), y.end(), f.shear_y_pa.begin());
                  },
                  {Health::frozen});
}

TEST_P(Faults, AFewMillionthsOfThePressureAreNoContact) {
  expect_reported(grasp_,
                  [](FrameSlot& f) {
                    for (auto values : {f.normal_pa, f.shear_x_pa, f.shear_y_pa}) {
                      for (float& value : values) value *= 1e-6F;
                    }
                  },
                  {Health::wrong_scale});
}

TEST_P(Faults, ValuesBeyondAllSenseAreRefused) {
  expect_reported(grasp_,
                  [](FrameSlot& f) {
                    for (auto values : {f.normal_pa, f.shear_x_pa, f.shear_y_pa}) {
                      for (float& value : values) value *= 1e25F;
                    }
                  },
                  {Health::full_scale, Health::not_finite});
}

TEST_P(Faults, ValuesThatAreNoNumbersAreNoLostContact) {
  grasp_.load();
  const auto estimates = grasp_.go(20, kNormal_n, GraspWithFault::kLoaded_n, [](FrameSlot& f) {
    for (auto values : {f.normal_pa, f.shear_x_pa, f.shear_y_pa})
      std::fill(values.begin(), values.end(), std::numeric_limits<float>::quiet_NaN());
  });
  EXPECT_EQ(estimates.front().health, Health::not_finite);
  for (const Estimate& at : estimates) {
    EXPECT_TRUE(at.health == Health::not_finite || at.health == Health::frozen) << to_string(at.health);
    EXPECT_NE(at.state, State::no_contact);
    EXPECT_FALSE(at.normal_n && !std::isfinite(*at.normal_n));
  }
}

TEST_P(Faults, OneFrameOfAnotherScaleDoesNotEndTheMarginsOfTheGrip) {
  grasp_.load();
  for (const float scale : {950.0F, 2000.0F, 1e6F}) {
    grasp_.go(1, kNormal_n, GraspWithFault::kLoaded_n, [scale](FrameSlot& f) {
      for (auto values : {f.normal_pa, f.shear_x_pa, f.shear_y_pa})
        for (float& value : values) value *= scale;
    });
    EXPECT_EQ(grasp_.go(20, kNormal_n, GraspWithFault::kLoaded_n).back().health, Health::good) << scale;
  }
}

TEST_P(Faults, OnePressureOnAllTaxelsIsNoContact) {
  expect_reported(grasp_,
                  [](FrameSlot& f) {
                    for (auto values : {f.normal_pa, f.shear_x_pa, f.shear_y_pa})
                      std::fill(values.begin(), values.end(), values[values.size() / 2]);
                  },
                  {Health::uniform});
}

TEST_P(Faults, ShearThatIsClippedGivesNoMargin) {
  expect_reported(grasp_,
                  [](FrameSlot& f) {
                    for (auto values : {f.shear_x_pa, f.shear_y_pa}) {
                      for (float& value : values) value = std::clamp(value, -kClip_pa, kClip_pa);
                    }
                  },
                  {Health::saturated});
}

// Where it is left out the margin is of the other taxels.
TEST_P(Faults, ASingleTaxelThatReadsWhatNoContactMakesIsLeftOut) {
  const std::size_t side = GetParam().side, middle = side / 2 * side + side / 2, corner = side * side - 1;
  constexpr float kValues_pa[] = {5e6F, 1e8F, 1e30F, std::numeric_limits<float>::quiet_NaN()};
  for (const std::size_t taxel : {middle, corner}) {
    for (const float value_pa : kValues_pa) {
      SCOPED_TRACE(std::to_string(value_pa) + " at " + std::to_string(taxel));
      GraspWithFault grasp{GetParam()};
      expect_reported(grasp, [=](FrameSlot& f) { f.normal_pa[taxel] = value_pa; }, {Health::spike});
    }
  }
}

TEST_P(Faults, ATenthOfTheShearAlongXIsNoSaferGrip) {
  expect_reported(grasp_,
                  [](FrameSlot& f) {
                    for (float& value : f.shear_x_pa) value *= 0.1F;
                  },
                  {Health::jump});
}

TEST_P(Faults, ExchangedAxesAreNoGraspThatGoesOn) {
  expect_reported(
      grasp_,
      [](FrameSlot& f) { std::swap_ranges(f.shear_x_pa.begin(), f.shear_x_pa.end(), f.shear_y_pa.begin()); },
      {Health::jump});
}

TEST_P(Faults, AThousandfoldUnitIsRefused) {
  expect_reported(grasp_,
                  [](FrameSlot& f) {
                    for (auto values : {f.normal_pa, f.shear_x_pa, f.shear_y_pa}) {
                      for (float& value : values) value *= 1e3F;
                    }
                  },
                  {Health::wrong_scale, Health::full_scale});
}

TEST_P(Faults, AColumnThatDiesIsAFault) {
  const std::size_t side = GetParam().side;
  expect_reported(grasp_,
                  [side](FrameSlot& f) {
                    for (auto values : {f.normal_pa, f.shear_x_pa, f.shear_y_pa}) {
                      for (std::size_t i = side / 2; i < values.size(); i += side) values[i] = 0;
                    }
                  },
                  {Health::dead_row, Health::jump});
}

TEST_P(Faults, AStuckBitOfOneShearIsLeftOut) {
  const std::size_t side = GetParam().side, middle = side / 2 * side + side / 2;
  expect_reported(grasp_, [middle](FrameSlot& f) { f.shear_x_pa[middle] += 1e6F; }, {Health::spike});
}

TEST_P(Faults, AShearChannelThatBecomesNoisyGivesNoMargin) {
  std::mt19937 random{1};
  std::uniform_real_distribution<float> noise_pa(-2e4F, 2e4F);
  expect_reported(grasp_,
                  [&](FrameSlot& f) {
                    for (float& value : f.shear_x_pa) value += noise_pa(random);
                  },
                  {Health::noisy, Health::jump});
}

TEST_P(Faults, AJumpLastsUntilTheObjectIsLetGo) {
  grasp_.load();
  grasp_.go(20, kNormal_n, GraspWithFault::kLoaded_n, [](FrameSlot& f) {
    std::swap_ranges(f.shear_x_pa.begin(), f.shear_x_pa.end(), f.shear_y_pa.begin());
  });
  for (const Estimate& at : grasp_.go(100, kNormal_n, GraspWithFault::kLoaded_n)) {
    EXPECT_EQ(at.health, Health::jump);
    EXPECT_FALSE(at.gamma.has_value());
  }
  grasp_.go(40, 1e-6, 0);
  EXPECT_EQ(grasp_.go(40, kNormal_n, GraspWithFault::kLoaded_n).back().health, Health::good);
}

TEST_P(Faults, AreOverSoonAfterTheSensorIsSoundAgain) {
  grasp_.load();
  grasp_.go(20, kNormal_n, GraspWithFault::kLoaded_n, [](FrameSlot& f) { zero(f.shear_x_pa); });
  const auto estimates = grasp_.go(100, kNormal_n, 1.2 * GraspWithFault::kLoaded_n);
  EXPECT_EQ(estimates.back().health, Health::good);
  EXPECT_NE(estimates.back().state, State::fault);
}

INSTANTIATE_TEST_SUITE_P(Layouts, Faults,
                         ::testing::Values(Case{4, MethodChoice::fit, synthetic::Noise::sensor},
                                           Case{16, MethodChoice::moments, synthetic::Noise::sensor},
                                           Case{16, MethodChoice::fit, synthetic::Noise::relative},
                                           Case{100, MethodChoice::moments, synthetic::Noise::sensor}),
                         [](const auto& of) {
                           return std::to_string(of.param.side) +
                                  (of.param.method == MethodChoice::fit ? "fit" : "moments") +
                                  (of.param.noise == synthetic::Noise::sensor ? "sensor" : "relative");
                         });

// A flat skin of 4 x 4 taxels at 100 frames a second.
class FlatSkin {
 public:
  // Each taxel carries its part of the force; on all of them comes an offset.
  Health sense(double normal_n, double offset_pa) {
    std::normal_distribution<double> noise_pa(0, 20);
    std::vector<float> p(16), x(16), y(16);
    for (std::size_t i = 0; i < p.size(); ++i) {
      const double share = (1 + 0.5 * std::sin(2.3 * static_cast<double>(i))) / 16;
      const double pressure_pa = normal_n * share / layout_.area_m2();
      p[i] = static_cast<float>(pressure_pa + offset_pa + noise_pa(random_));
      x[i] = static_cast<float>(0.3 * pressure_pa + noise_pa(random_));
      y[i] = static_cast<float>(noise_pa(random_));
    }
    const Frame frame{++sequence_, static_cast<std::int64_t>(10'000'000 * sequence_), p, x, y};
    const ContactPatch& patch = finder_.find(frame);
    monitor_.screen(frame, patch);
    return monitor_.judge(frame, patch).health;
  }

 private:
  TaxelLayout layout_ = TaxelLayout::grid(4, 4, 4.7e-3);
  PatchFinder finder_{layout_};
  PlausibilityMonitor monitor_{
      layout_, {.full_scale = default_full_scale(SensorClass::array3, layout_), .flat = true}};
  std::mt19937_64 random_{5};
  std::uint64_t sequence_ = 0;
};

TEST(Plausibility, AnOffsetOfAllTaxelsOfAHeldFlatSkinIsNoFirmGrip) {
  FlatSkin skin;
  for (int i = 0; i < 40; ++i) ASSERT_EQ(skin.sense(3, 0), Health::good) << i;
  for (int i = 0; i < 40; ++i) EXPECT_EQ(skin.sense(3, 4e5), Health::jump) << i;
  Health last = Health::jump;
  for (int i = 0; i < 20; ++i) last = skin.sense(3, 0);
  EXPECT_EQ(last, Health::good);
}

TEST(Plausibility, AFlatSkinMayBeGrippedAtOnce) {
  FlatSkin skin;
  for (int i = 0; i < 40; ++i) ASSERT_EQ(skin.sense(0, 0), Health::good) << i;
  for (const double grip_n : {0.5, 4.0, 8.0, 8.0}) EXPECT_EQ(skin.sense(grip_n, 0), Health::good) << grip_n;
  for (int i = 0; i < 40; ++i) ASSERT_EQ(skin.sense(2, 0), Health::good) << i;
  for (const double grip_n : {6.0, 12.0}) EXPECT_EQ(skin.sense(grip_n, 0), Health::good) << grip_n;
}

class OneFrame : public ::testing::Test {
 protected:
  OneFrame() {
    contact::LoadHistory contact(synthetic::paper_pair());
    contact.move_to(2, 0.3, kGripFriction);
    frame_ = maker_.make(contact, 0, 0, 0.3, 0.01);
    patch_ = finder_.find(frame_);
  }
  const Judgement& judge() {
    monitor_.screen(frame_, patch_);
    return monitor_.judge(frame_, patch_);
  }

  TaxelLayout layout_ = TaxelLayout::grid(16, 16, 1e-3);
  PatchFinder finder_{layout_};
  PlausibilityMonitor monitor_{layout_, {.full_scale = default_full_scale(SensorClass::array3, layout_)}};
  synthetic::FrameMaker maker_{layout_};
  Frame frame_;
  ContactPatch patch_;
};

// A contact may lie between the taxels that are compared.
TEST_F(OneFrame, WithAnotherShearIsNoRepeat) {
  judge();
  EXPECT_TRUE(judge().repeats);
  patch_.shear_x_n += 0.01;
  EXPECT_FALSE(judge().repeats);
}

TEST_F(OneFrame, IsJudgedWithoutMemory) {
  const std::uint64_t before = test::allocations();
  for (int i = 0; i < 100; ++i) judge();
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace slipd
