// A gel that relaxes against its own past is told as a slide; rigid motion, stretch that stays, noise, lost
// points and a robot that lets go are not.
#include "core/sliding/gel_relaxation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

namespace slipd {
namespace {

constexpr std::size_t kGelColumns = 9, kGelRows = 7;
constexpr double kPicture_s = 1.0 / 25, kSlowPicture_s = 1.0 / 18, kDotNoise_mm = 0.0025;

// Displacement in mm at a place in mm.
struct Moved {
  double x = 0, y = 0;
};
using Field = std::function<Moved(double x_mm, double y_mm)>;

Moved unmoved(double, double) {
  return {};
}
// A contact that bulges the gel outwards, by about `mm`.
Field bulge(double mm) {
  return [mm](double x, double y) {
    const double each = mm * std::exp(-(x * x + y * y) / 8);
    return Moved{each * x / 2, each * y / 2};
  };
}
Field plus(const Field& a, const Field& b) {
  return [a, b](double x, double y) {
    const Moved of_a = a(x, y), of_b = b(x, y);
    return Moved{of_a.x + of_b.x, of_a.y + of_b.y};
  };
}
Field along(double mm) {
  return [mm](double, double) { return Moved{mm, 0}; };
}
Field turned(double rad) {
  return [rad](double x, double y) { return Moved{-rad * y, rad * x}; };
}

class Gel {
 public:
  explicit Gel(double picture_s = kPicture_s)
      : layout_(TaxelLayout::grid(kGelColumns, kGelRows, 0.0018)),
        relaxation_(layout_),
        picture_s_(picture_s) {}

  GelRelaxation& relaxation() { return relaxation_; }
  // Shows the field for so many pictures; whether a slide was told in any of them.
  bool slides_in(int pictures, const Field& field, double lost_share = 0) {
    bool slid = false;
    for (int i = 0; i < pictures; ++i) {
      show(field, lost_share);
      slid = slid || slides(state_.sliding);
    }
    return slid;
  }
  const GelState& state() const { return state_; }
  void set_clock_by(double seconds) { time_s_ += seconds; }

 private:
  void show(const Field& field, double lost_share) {
    std::normal_distribution<double> noise(0, kDotNoise_mm);
    std::bernoulli_distribution lost(lost_share);
    std::vector<float> x(layout_.size()), y(layout_.size()), change(layout_.size());
    for (std::size_t i = 0; i < layout_.size(); ++i) {
      const Moved moved = field(1e3 * layout_.x_m()[i], 1e3 * layout_.y_m()[i]);
      const bool gone = lost(random_);
      x[i] = gone ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(moved.x + noise(random_));
      y[i] = gone ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(moved.y + noise(random_));
    }
    time_s_ += picture_s_;
    state_ = relaxation_.update(
        {.time_ns = std::llround(1e9 * time_s_), .normal_pa = change, .shear_x_pa = x, .shear_y_pa = y});
  }

  TaxelLayout layout_;
  GelRelaxation relaxation_;
  std::mt19937 random_{7};
  const double picture_s_;
  double time_s_ = 0;
  GelState state_;
};

TEST(GelRelaxation, NoContactIsNoSlide) {
  Gel gel;
  EXPECT_FALSE(gel.slides_in(200, unmoved));
  EXPECT_NE(gel.state().contact, std::optional(true));
  EXPECT_LT(gel.state().evidence, 0.5);
}

TEST(GelRelaxation, AWeakContactThatIsLostIsASlideThoughOnePictureWouldNotShowTheContact) {
  Gel gel;
  gel.slides_in(40, unmoved);
  EXPECT_FALSE(gel.slides_in(60, bulge(0.06)));
  EXPECT_NE(gel.state().contact, std::optional(true));
  EXPECT_TRUE(gel.slides_in(20, unmoved));
}

TEST(GelRelaxation, ACameraThatComesToEighteenPicturesOfTwentyFiveTellsTheSame) {
  Gel gel(kSlowPicture_s);
  EXPECT_FALSE(gel.slides_in(40, unmoved));
  EXPECT_FALSE(gel.slides_in(60, bulge(0.3)));
  EXPECT_TRUE(gel.slides_in(20, unmoved));
  EXPECT_EQ(gel.state().contact, false);
}

TEST(GelRelaxation, AHeldObjectIsAContactAndNoSlide) {
  Gel gel;
  EXPECT_FALSE(gel.slides_in(40, unmoved));
  EXPECT_FALSE(gel.slides_in(200, bulge(0.3)));
  EXPECT_EQ(gel.state().contact, true);
  EXPECT_EQ(gel.state().sliding, Sliding::none);
}

TEST(GelRelaxation, OnePictureOfTheFutureDoesNotBlindIt) {
  Gel gel;
  gel.slides_in(40, unmoved);
  gel.set_clock_by(3600);
  gel.slides_in(1, bulge(0.3));
  gel.set_clock_by(-3600);
  EXPECT_FALSE(gel.slides_in(60, bulge(0.3)));
  EXPECT_TRUE(gel.slides_in(20, unmoved));
}

TEST(GelRelaxation, AGelThatRelaxesIsASlide) {
  Gel gel;
  gel.slides_in(40, unmoved);
  gel.slides_in(60, bulge(0.3));
  EXPECT_TRUE(gel.slides_in(20, unmoved));
  EXPECT_FALSE(gel.slides_in(80, unmoved) && slides(gel.state().sliding)) << "it does not end";
  EXPECT_EQ(gel.state().contact, false);
}

TEST(GelRelaxation, AGelThatComesToRestIsToldWithinTwoPicturesAndOneWildPictureIsNone) {
  Gel gel;
  gel.slides_in(40, unmoved);
  gel.slides_in(60, bulge(0.5));
  EXPECT_FALSE(gel.slides_in(1, unmoved));
  EXPECT_FALSE(gel.slides_in(60, bulge(0.5)));
  EXPECT_TRUE(gel.slides_in(2, unmoved));
}

TEST(GelRelaxation, ASlightFallIsToldOnlyOnceItHasLasted) {
  Gel gel;
  gel.slides_in(40, unmoved);
  gel.slides_in(60, bulge(0.5));
  EXPECT_FALSE(gel.slides_in(6, bulge(0.32)));
  EXPECT_TRUE(gel.slides_in(6, bulge(0.32)));
}

TEST(GelRelaxation, AlsoIfTheFirstPictureShowsTheContact) {
  Gel gel;
  EXPECT_FALSE(gel.slides_in(60, bulge(0.3)));
  EXPECT_TRUE(gel.slides_in(20, unmoved));
}

TEST(GelRelaxation, RigidMotionAndTurningOfAHeldObjectAreNone) {
  Gel gel;
  gel.slides_in(60, bulge(0.3));
  EXPECT_FALSE(gel.slides_in(40, plus(bulge(0.3), along(0.4))));
  EXPECT_FALSE(gel.slides_in(40, plus(bulge(0.3), turned(0.08))));
}

TEST(GelRelaxation, ATighterGripIsNone) {
  Gel gel;
  gel.slides_in(60, bulge(0.2));
  EXPECT_FALSE(gel.slides_in(60, bulge(0.5)));
}

TEST(GelRelaxation, TellsATurnFromAWay) {
  Gel turning, sliding;
  turning.slides_in(60, plus(bulge(0.3), turned(0.1)));
  sliding.slides_in(60, plus(bulge(0.3), along(0.4)));
  turning.slides_in(13, unmoved);
  sliding.slides_in(13, unmoved);
  EXPECT_EQ(turning.state().sliding, Sliding::rotation);
  EXPECT_EQ(sliding.state().sliding, Sliding::translation);
}

TEST(GelRelaxation, StalePicturesOfAContactFromBeforeTheStartAreNoSlide) {
  Gel gel;
  gel.slides_in(5, unmoved);
  gel.slides_in(7, bulge(0.6));
  EXPECT_FALSE(gel.slides_in(60, unmoved));
  gel.slides_in(7, bulge(0.6));
  EXPECT_TRUE(gel.slides_in(60, unmoved)) << "the same later";
}

TEST(GelRelaxation, AGelThatSlipsWhileItIsFirstSeenKeepsItsPast) {
  Gel gel;
  for (int i = 0; i < 5; ++i) gel.slides_in(1, plus(bulge(0.6 * (1 - 0.2 * i)), along(0.1 * i)));
  EXPECT_TRUE(gel.slides_in(20, along(0.5)));
}

TEST(GelRelaxation, LostPointsAreLeftOut) {
  Gel gel;
  EXPECT_FALSE(gel.slides_in(100, bulge(0.3), 0.2));
  EXPECT_TRUE(gel.slides_in(20, unmoved, 0.2));
  gel.slides_in(1, unmoved, 0.9);
  EXPECT_FALSE(gel.state().sliding.has_value()) << "hardly a point is seen";
}

TEST(GelRelaxation, ARobotThatLetsGoMutesIt) {
  Gel gel;
  gel.slides_in(60, bulge(0.3));
  gel.relaxation().set_releasing(true);
  EXPECT_FALSE(gel.slides_in(40, unmoved));
  EXPECT_EQ(gel.state().evidence, 0);
  gel.relaxation().set_releasing(false);
  EXPECT_FALSE(gel.slides_in(40, unmoved));
}

}  // namespace
}  // namespace slipd
