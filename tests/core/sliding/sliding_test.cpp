// Sliding is seen where the pattern of the taxels moves, and only there. A rough block is moved over a pad of
// taxels: what it does is known, and no friction enters.
#include "core/sliding/sliding.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "tests/support/heap_count.hpp"

namespace slipd {
namespace {

constexpr double kRateHz = 200;
constexpr double kFalseAlarmsPerHour = 1;

// A contact on a pad: a bump of pressure with a texture, shear along x.
struct Contact {
  double normal = 1;   // of the pressure, no unit
  double shear = 0.1;  // shear over pressure
  double x_m = 0, turned = 0;
  double outward = 0, twist = 0;  // shear over pressure at 5 mm from the middle: away from it, about it
};

class Pad {
 public:
  explicit Pad(std::size_t side, double noise)
      : layout_(TaxelLayout::grid(side, side, 0.012 / static_cast<double>(side))), noise_(noise) {
    normal_.resize(layout_.size());
    shear_x_.resize(layout_.size());
    shear_y_.resize(layout_.size());
  }
  const TaxelLayout& layout() const { return layout_; }

  Frame frame(double time_s, const Contact& contact, double offset = 0) {
    for (std::size_t i = 0; i < layout_.size(); ++i) {
      const double x = layout_.x_m()[i], y = layout_.y_m()[i];
      const double r2 = (x * x + y * y) / (0.005 * 0.005);
      const double c = std::cos(contact.turned), s = std::sin(contact.turned);
      const double u = c * x + s * y - contact.x_m, v = -s * x + c * y;
      const double texture = 1 + 0.3 * std::sin(u / 0.0008) + 0.3 * std::cos(v / 0.0011);
      const double p = 1e4 * contact.normal * std::exp(-r2) * texture;
      normal_[i] = static_cast<float>(p + offset + noise_ * gauss_(random_));
      const double q_x = contact.shear + (contact.outward * x - contact.twist * y) / 0.005;
      const double q_y = (contact.outward * y + contact.twist * x) / 0.005;
      shear_x_[i] = static_cast<float>(q_x * p + offset + noise_ * gauss_(random_));
      shear_y_[i] = static_cast<float>(q_y * p + offset + noise_ * gauss_(random_));
    }
    return {.sequence = ++sequence_,
            .time_ns = static_cast<std::int64_t>(time_s * 1e9),
            .normal_pa = normal_,
            .shear_x_pa = shear_x_,
            .shear_y_pa = shear_y_,
            .zeroed = offset == 0};
  }

 private:
  TaxelLayout layout_;
  double noise_;
  std::mt19937_64 random_{7};
  std::normal_distribution<double> gauss_;
  std::vector<float> normal_, shear_x_, shear_y_;
  std::uint64_t sequence_ = 0;
};

struct Seen {
  bool slid = false, disturbed = false, none = false, turned = false;
  double first_s = -1;
};

Seen watch(Pad& pad, double seconds, const std::function<Contact(double)>& course, double offset = 0) {
  SlidingDetector detector(pad.layout(), kFalseAlarmsPerHour);
  Seen seen;
  for (double t = 0; t < seconds; t += 1 / kRateHz) {
    const SlidingVerdict verdict = detector.update(pad.frame(t, course(t), offset), true);
    if (!verdict.sliding) continue;
    seen.none |= *verdict.sliding == Sliding::none;
    seen.disturbed |= *verdict.sliding == Sliding::disturbed && t > 0.5;
    seen.turned |= *verdict.sliding == Sliding::rotation;
    if (slides(verdict.sliding) && !seen.slid) seen.first_s = t;
    seen.slid |= slides(verdict.sliding);
  }
  return seen;
}

TEST(Sliding, IsNoneInAStillHold) {
  Pad pad(4, 50);
  const Seen seen = watch(pad, 60, [](double) { return Contact{}; });
  EXPECT_TRUE(seen.none);
  EXPECT_FALSE(seen.slid);
  EXPECT_FALSE(seen.disturbed);
}

TEST(Sliding, IsSeenSoonAfterTheTextureBeginsToMove) {
  Pad pad(4, 50);
  const Seen seen = watch(pad, 3, [](double t) { return Contact{.x_m = t < 2 ? 0 : 0.005 * (t - 2)}; });
  ASSERT_TRUE(seen.slid);
  EXPECT_GT(seen.first_s, 2);
  EXPECT_LT(seen.first_s, 2.4);
}

TEST(Sliding, IsSeenAfterAFrameOfTheFutureToo) {
  Pad pad(4, 50);
  SlidingDetector detector(pad.layout(), kFalseAlarmsPerHour);
  bool slid = false;
  for (double t = 0; t < 4; t += 1 / kRateHz) {
    const bool future = std::fabs(t - 1) < 0.5 / kRateHz;
    const Contact contact{.x_m = t < 3 ? 0 : 0.005 * (t - 3)};
    const SlidingVerdict verdict = detector.update(pad.frame(future ? 3600 : t, contact), true);
    slid |= t > 3 && slides(verdict.sliding);
  }
  EXPECT_TRUE(slid);
}

TEST(Sliding, IsNotTakenFromAnOvershootThatRelaxes) {
  Pad pad(4, 50);
  const Seen seen = watch(pad, 5, [](double t) { return Contact{.normal = 1 + 2.6 * std::exp(-t / 0.2)}; });
  EXPECT_FALSE(seen.slid);
}

TEST(Sliding, IsDisturbedWhenAnObjectThatSticksIsPulled) {
  Pad pad(4, 50);
  const Seen seen =
      watch(pad, 5, [](double t) { return Contact{.shear = t < 2 ? 0.1 : std::min(0.4, 0.1 + t - 2)}; });
  EXPECT_FALSE(seen.slid);
  EXPECT_TRUE(seen.disturbed);
}

TEST(Sliding, IsNotTakenFromAGripThatOpens) {
  Pad pad(4, 50);
  const Seen seen =
      watch(pad, 4, [](double t) { return Contact{.normal = t < 3 ? 1 : std::max(0.01, 1 - 10 * (t - 3))}; });
  EXPECT_FALSE(seen.slid);
}

// The grip still relaxes by more than 5 % in 0.15 s when the object begins to slide.
TEST(Sliding, IsSeenWhileTheGripStillRelaxes) {
  Pad pad(4, 50);
  const auto course = [](double t) {
    const double relaxed = 0.75 + 0.25 * std::exp(-std::max(0.0, t - 0.3) / 0.25);
    return Contact{.normal = 3 * relaxed * std::min(1.0, t / 0.3), .x_m = std::max(0.0, t - 0.6) * 0.006};
  };
  EXPECT_FALSE(watch(pad, 0.6, course).slid);
  EXPECT_TRUE(watch(pad, 1.2, course).slid);
}

// Ten frames a second: each is a block of its own, and needs no later one to be complete.
TEST(Sliding, OfASlowSensorIsSeenInTheFramesThatShowIt) {
  constexpr double kSlowHz = 10;
  Pad pad(4, 50);
  SlidingDetector detector(pad.layout(), kFalseAlarmsPerHour);
  int first = -1;
  for (int i = 0; i < 40; ++i) {
    const double slid_m = i < 20 ? 0 : 0.0006 * (i - 19);
    const SlidingVerdict verdict = detector.update(pad.frame(i / kSlowHz, {.x_m = slid_m}), true);
    if (slides(verdict.sliding) && first < 0) first = i;
    if (i >= 4 && i < 20) {
      EXPECT_EQ(verdict.sliding, Sliding::none) << i;
    }
  }
  EXPECT_GE(first, 20);
  EXPECT_LE(first, 21);
}

TEST(Sliding, OfManyTaxelsIsSeenInCells) {
  Pad pad(40, 50);
  EXPECT_TRUE(watch(pad, 3, [](double t) { return Contact{.x_m = t < 2 ? 0 : 0.01 * (t - 2)}; }).slid ||
              watch(pad, 3, [](double t) { return Contact{.turned = t < 2 ? 0 : 0.5 * (t - 2)}; }).slid);
  EXPECT_FALSE(watch(pad, 10, [](double) { return Contact{}; }).slid);
}

TEST(Sliding, NeedsNoZero) {
  constexpr double kOffset = 3e4;
  Pad pad(4, 50);
  EXPECT_FALSE(watch(
                   pad, 30, [](double) { return Contact{}; }, kOffset)
                   .slid);
  EXPECT_TRUE(
      watch(
          pad, 3, [](double t) { return Contact{.shear = t < 2 ? 0.1 : 0.1 + 0.5 * (t - 2)}; }, kOffset)
          .slid);
}

// The course of the field at the end.
FieldCourse field_after(double seconds, const std::function<Contact(double)>& course) {
  Pad pad(4, 50);
  SlidingDetector detector(pad.layout(), kFalseAlarmsPerHour);
  FieldCourse field;
  for (double t = 0; t < seconds; t += 1 / kRateHz)
    field = detector.update(pad.frame(t, course(t)), true).field;
  return field;
}

TEST(FieldCourse, OfAPullIsCoherentThoughPressingShearsOutwards) {
  const auto pulled = [](double t) { return Contact{.shear = t < 1 ? 0 : 0.3 * (t - 1), .outward = 0.3}; };
  EXPECT_LT(field_after(1, pulled).coherence, 0.3);
  const FieldCourse field = field_after(2, pulled);
  EXPECT_TRUE(field.settled);
  EXPECT_GT(field.coherence, 0.95);
  EXPECT_LT(field.internal_share, 0.03);
}

TEST(FieldCourse, OfATurnIsNotCoherentAndItsTaxelsCarryAgainstEachOther) {
  const FieldCourse field =
      field_after(2, [](double t) { return Contact{.shear = 0, .twist = t < 1 ? 0 : 0.4 * (t - 1)}; });
  EXPECT_LT(field.coherence, 0.3);
  EXPECT_GT(field.internal_share, 0.1);
}

TEST(FieldCourse, ShearOfPressingGrowsWithTheForceAndIsNoInternalLoad) {
  const FieldCourse field = field_after(3, [](double t) {
    return Contact{.normal = t < 1 ? 1 : 1 - 0.15 * (t - 1), .outward = 0.4, .twist = 0.2};
  });
  EXPECT_LT(field.internal_share, 0.02);
  EXPECT_NE(field.pressing_lever_m, 0);
}

TEST(Sliding, IsNotToldByAForceAlone) {
  SlidingDetector detector(TaxelLayout::wrench(0.01), kFalseAlarmsPerHour);
  std::vector<float> one{1};
  for (int i = 0; i < 1000; ++i) {
    one[0] = static_cast<float>(i);
    EXPECT_FALSE(
        detector
            .update({.time_ns = i * 5'000'000LL, .normal_pa = one, .shear_x_pa = one, .shear_y_pa = one},
                    true)
            .sliding);
  }
}

TEST(Sliding, AllocatesNothing) {
  Pad pad(40, 50);
  SlidingDetector detector(pad.layout(), kFalseAlarmsPerHour);
  const Frame frame = pad.frame(0, {});
  Frame at = frame;
  const auto before = test::allocations();
  for (int i = 0; i < 1000; ++i) {
    at.time_ns = i * 5'000'000LL;
    detector.update(at, true);
  }
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace slipd
