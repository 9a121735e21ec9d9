// The angle that an object turned by is that of its imprint, and unknown where the imprint has no direction.
#include "core/sliding/turned_angle.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "tests/support/heap_count.hpp"

namespace slipd {
namespace {

constexpr double kFrame_s = 0.005;
constexpr double kRadius_m = 0.004;
constexpr double kDeg = std::numbers::pi / 180;

// Pressure over its peak at a place of the object, in contact radii.
using Imprint = std::function<double(double x, double y)>;

double dome(double square) {
  return std::sqrt(std::max(0.0, 1 - square));
}
// Axes of `axes` : 1, of the same area as a round contact.
Imprint ellipse(double axes) {
  return [axes](double x, double y) { return dome(x * x / axes + y * y * axes); };
}
// Three bumps, as of a knurled knob.
double three_bumps(double x, double y) {
  const double r = std::hypot(x, y);
  return dome(r * r) * (1 + 0.5 * r * r * std::cos(3 * std::atan2(y, x)));
}

// A contact that lies on a pad of 16 mm, seen every 5 ms.
class TurningImprint {
 public:
  TurningImprint(std::size_t side, Imprint imprint, double noise = 0.01)
      : layout_(TaxelLayout::grid(side, side, 0.016 / static_cast<double>(side))),
        imprint_(std::move(imprint)),
        noise_(noise),
        finder_(layout_),
        follower_(layout_),
        normal_(layout_.size()),
        none_(layout_.size()) {}

  // Frames in which the object turns evenly by so much.
  std::optional<TurnedAngle> turn(double by_rad, int frames, bool slides_turning = false) {
    // Frames by which an angle is late at most: those between two looks, and the followed pattern's.
    constexpr int kLate = 16;
    const double late_rad = kLate * std::fabs(by_rad) / frames;
    std::optional<TurnedAngle> last;
    for (int i = 0; i < frames; ++i) {
      turned_rad_ += by_rad / frames;
      last = see(slides_turning);
      if (last) {
        EXPECT_NEAR(last->angle_rad, turned_rad_, late_rad + 0.02 + 3 * last->sigma_rad) << i;
      }
    }
    return last;
  }
  std::optional<TurnedAngle> see(bool slides_turning = false) {
    sense();
    const Frame frame{++sequence_, time_ns_, normal_, none_, none_};
    return follower_.update(time_ns_ += static_cast<std::int64_t>(kFrame_s * 1e9), finder_.find(frame),
                            settled_, slides_turning);
  }
  void close() {
    settled_ = false;
    for (int i = 0; i < 20; ++i) see();
    settled_ = true;
  }
  void pause_s(double seconds) { time_ns_ += static_cast<std::int64_t>(seconds * 1e9); }
  double turned_rad() const { return turned_rad_; }
  double x_m = 3e-4, y_m = -2e-4;  // of the contact
  bool imprint_turns = true;

 private:
  void sense() {
    constexpr int kParts = 4;
    const double side_m = layout_.side_m(), turned_rad = imprint_turns ? turned_rad_ : 0;
    const double c = std::cos(turned_rad), s = std::sin(turned_rad);
    std::uniform_real_distribution<float> unit(-1, 1);
    for (std::size_t i = 0; i < layout_.size(); ++i) {
      double p = 0;
      for (int part = 0; part < kParts * kParts; ++part) {
        const double x =
            (layout_.x_m()[i] - x_m + ((part % kParts + 0.5) / kParts - 0.5) * side_m) / kRadius_m;
        const double y =
            (layout_.y_m()[i] - y_m + ((part / kParts + 0.5) / kParts - 0.5) * side_m) / kRadius_m;
        p += imprint_(c * x + s * y, c * y - s * x);
      }
      normal_[i] = static_cast<float>(1e5 * p / (kParts * kParts));
      normal_[i] += static_cast<float>(1e5 * noise_) * unit(random_);
    }
  }

  TaxelLayout layout_;
  Imprint imprint_;
  double noise_;
  PatchFinder finder_;
  TurnFollower follower_;
  std::vector<float> normal_, none_;
  std::mt19937_64 random_{4};
  double turned_rad_ = 0;
  bool settled_ = false;
  std::int64_t time_ns_ = 1'000'000'000;
  std::uint64_t sequence_ = 0;
};

TEST(TurnedAngles, AreThoseOfTheImprintOnFineAndOnCoarseArrays) {
  for (const std::size_t side : {32U, 16U, 8U}) {
    std::vector<Imprint> imprints{ellipse(1.5), ellipse(2)};
    if (side > 8) imprints.emplace_back(three_bumps);  // narrower than taxels of 2 mm
    for (const Imprint& imprint : imprints) {
      TurningImprint contact(side, imprint);
      contact.close();
      contact.turn(0, 40);
      for (const double by_deg : {6.0, -25.0, 130.0}) {
        contact.turn(by_deg * kDeg, 200);
        const auto found = contact.turn(0, 40);
        ASSERT_TRUE(found) << side << ' ' << by_deg;
        EXPECT_NEAR(found->angle_rad / kDeg, contact.turned_rad() / kDeg, 3) << side;
        EXPECT_LT(found->sigma_rad, 6 * kDeg) << side;
      }
    }
  }
}

TEST(TurnedAngles, AreWithinTwoSigmasAsOftenAsTheySay) {
  int within = 0, all = 0;
  for (const std::size_t side : {24U, 12U}) {
    for (int place = 0; place < 12; ++place) {
      TurningImprint contact(side, ellipse(1.4));
      contact.x_m = 1e-4 * place;
      contact.y_m = -7e-5 * place;
      contact.close();
      contact.turn(0, 40);
      for (int step = 0; step < 6; ++step) {
        contact.turn(11 * kDeg, 20);
        const auto found = contact.turn(0, 40);
        ASSERT_TRUE(found);
        ++all;
        within += std::fabs(found->angle_rad - contact.turned_rad()) < 2 * found->sigma_rad ? 1 : 0;
      }
    }
  }
  EXPECT_GT(within, 0.9 * all);
}

TEST(TurnedAngles, OfRoundContactsAreNotKnown) {
  for (const std::size_t side : {48U, 32U, 16U, 8U, 4U}) {
    for (int place = 0; place < 20; ++place) {
      TurningImprint contact(side, ellipse(1));
      contact.x_m = 6e-5 * place;
      contact.y_m = 4e-5 * place;
      contact.close();
      for (int i = 0; i < 60; ++i) EXPECT_FALSE(contact.see()) << side << ' ' << place;
    }
  }
}

TEST(TurnedAngles, AreNotKnownBeforeTheContactHasSettledNorWhereTheSensorEnds) {
  TurningImprint contact(32, ellipse(1.6));
  for (int i = 0; i < 40; ++i) EXPECT_FALSE(contact.see());
  contact.close();
  contact.turn(0, 40);
  EXPECT_TRUE(contact.see());
  contact.x_m = 0.007;
  for (int i = 0; i < 20; ++i) contact.see();
  EXPECT_FALSE(contact.see());
}

TEST(TurnedAngles, EndWithAPauseInWhichTheObjectMayHaveTurnedFurther) {
  TurningImprint contact(32, ellipse(1.6));
  contact.close();
  contact.turn(0, 40);
  ASSERT_TRUE(contact.see());
  contact.pause_s(1);
  for (int i = 0; i < 40; ++i) EXPECT_FALSE(contact.see());
}

// A flat object on a finger that is itself curved more one way than the other.
TEST(TurnedAngles, OfAnImprintThatStaysWhileTheObjectTurnsAreWithdrawn) {
  TurningImprint contact(32, ellipse(1.6));
  contact.imprint_turns = false;
  contact.close();
  contact.turn(0, 40);
  for (int i = 0; i < 20; ++i) contact.see(true);
  for (int i = 0; i < 60; ++i) contact.see(true);
  EXPECT_FALSE(contact.see(true));
  for (int i = 0; i < 60; ++i) EXPECT_FALSE(contact.see(false)) << "nor once it sticks again";
}

TEST(TurnedAngles, OfAnImprintThatTurnsWhileItSlidesAreGiven) {
  TurningImprint contact(32, ellipse(1.6));
  contact.close();
  contact.turn(0, 40);
  contact.turn(30 * kDeg, 100, true);
  EXPECT_TRUE(contact.turn(0, 10, true));
}

TEST(TurnedAngles, AllocateNothing) {
  TurningImprint contact(16, ellipse(1.6));
  contact.close();
  contact.turn(0, 40);
  const auto before = test::allocations();
  for (int i = 0; i < 20; ++i) contact.see();
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace slipd
