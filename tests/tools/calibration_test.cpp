// What known weights show of a sensor's scales, signs, axes and layout: sensors that are wrong in a known
// way.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

#include "tools/slipctl/calibrate.hpp"
#include "tools/slipctl/calibration/report.hpp"

namespace slipctl::calibration {
namespace {

using slipd::SensorClass;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr Weights kWeights{2, 1};
constexpr Pad kPad{SensorClass::array3, {-6, -6}, {6, 6}};

using Force = std::array<double, 3>;

// A sensor on a square pad of 12 mm that reads what a function makes of the true force and its place.
class WrongSensor {
 public:
  using ReadForce = std::function<Force(const Force&)>;
  using ReadPlace = std::function<std::array<double, 2>(std::array<double, 2>)>;

  explicit WrongSensor(
      ReadForce force, ReadPlace place = [](auto at) { return at; }, double noise_n = 0.01)
      : force_(std::move(force)), place_(std::move(place)), noise_(0, noise_n) {}

  // `creep`: part of the force by which it changes meanwhile.
  Reading read(const Force& true_n, std::array<double, 2> at_mm = {}, double creep = 0) {
    constexpr std::size_t kFrames = 300;
    const Force offset{0.3, -0.2, 0.5};
    const auto place = place_(at_mm);
    std::vector<FrameSums> frames(kFrames);
    for (std::size_t i = 0; i < kFrames; ++i) {
      const Force read = force_(true_n);
      const double swollen = 1 + creep * static_cast<double>(i) / kFrames;
      for (std::size_t axis = 0; axis < 3; ++axis)
        frames[i].force_n[axis] = offset[axis] + swollen * read[axis] + noise_(random_);
      for (std::size_t axis = 0; axis < 2; ++axis) frames[i].moment_nmm[axis] = place[axis] * read[kNormal];
    }
    return reading_of(frames);
  }

  Readings all(double preload_n = 0) {
    return {{Step::zero, read({0, 0, 0})},
            {Step::normal, read({0, 0, kWeights.normal_n})},
            {Step::shear_x, read({kWeights.shear_n, 0, preload_n})},
            {Step::shear_y, read({0, kWeights.shear_n, preload_n})},
            {Step::corner, read({0, 0, kWeights.normal_n}, {-5, -5})},
            {Step::corner_x, read({0, 0, kWeights.normal_n}, {5, -5})}};
  }

 private:
  ReadForce force_;
  ReadPlace place_;
  std::normal_distribution<double> noise_;
  std::mt19937_64 random_{1};
};

std::string refusal(const Pad& pad, const Weights& weights, const Readings& readings) {
  try {
    scales_of(pad, weights, readings);
  } catch (const CalibrationError& refused) {
    return refused.what();
  }
  return {};
}

void expect_factor(const AxisScale& found, double factor, std::size_t read_on) {
  EXPECT_EQ(found.read_on, read_on);
  EXPECT_NEAR(found.factor, factor, 5 * found.sigma) << "five standard deviations of its own";
  EXPECT_GT(found.sigma, 0);
  EXPECT_LT(found.sigma, 0.01 * std::fabs(factor));
}

TEST(Calibration, FindsTheScaleOfEachAxis) {
  WrongSensor sensor([](const Force& f) { return Force{f[0] / 2, f[1] / 3, f[2] / 4}; });
  const Scales scales = scales_of(kPad, kWeights, sensor.all());
  expect_factor(scales.normal, 4, kNormal);
  expect_factor(scales.x.value(), 2, kX);
  expect_factor(scales.y.value(), 3, kY);
  EXPECT_TRUE(scales.axes_in_place() && scales.signs_right());
  EXPECT_FALSE(scales.common());
}

TEST(Calibration, SaysAFactorsDeviationThatRepetitionsHave) {
  WrongSensor sensor([](const Force& f) { return f; }, [](auto at) { return at; }, 0.1);
  constexpr int kTimes = 200;
  double squares = 0;
  for (int i = 0; i < kTimes; ++i) {
    const AxisScale found = scales_of(kPad, kWeights, sensor.all()).normal;
    squares += std::pow((found.factor - 1) / found.sigma, 2) / kTimes;
  }
  EXPECT_NEAR(squares, 1.29, 0.7) << "sigma from ten parts each: Student's t of 9 to 18 degrees of freedom";
}

TEST(Calibration, FindsOneFactorForAllAxes) {
  WrongSensor sensor([](const Force& f) { return Force{2 * f[0], 2 * f[1], 2 * f[2]}; });
  const Scales scales = scales_of(kPad, kWeights, sensor.all());
  ASSERT_TRUE(scales.common());
  EXPECT_NEAR(scales.common()->factor, 0.5, 0.005);
}

TEST(Calibration, FindsWrongSignsAndExchangedAxesAlsoUnderAPreload) {
  for (const double preload_n : {0.0, 5.0}) {
    WrongSensor sensor([](const Force& f) { return Force{-f[1], f[0], -2 * f[2]}; });
    const Scales scales = scales_of(kPad, kWeights, sensor.all(preload_n));
    expect_factor(scales.normal, -0.5, kNormal);
    expect_factor(scales.x.value(), 1, kY);
    expect_factor(scales.y.value(), -1, kX);
    EXPECT_FALSE(scales.axes_in_place());
    EXPECT_FALSE(scales.signs_right());
  }
}

TEST(Calibration, FindsANormalThatIsOnAnotherAxis) {
  WrongSensor sensor([](const Force& f) { return Force{f[2], f[0], f[1]}; });
  Readings readings = sensor.all();
  readings.erase(Step::corner);
  readings.erase(Step::corner_x);
  const Scales scales = scales_of(kPad, kWeights, readings);
  EXPECT_EQ(scales.normal.read_on, kX);
  EXPECT_EQ(scales.x->read_on, kY);
  EXPECT_EQ(scales.y->read_on, kNormal);
}

// All eight ways to lay a square on itself.
TEST(Calibration, FindsEachTransposedOrMirroredLayoutByTwoCorners) {
  for (const bool transposed : {false, true}) {
    for (const bool mirrored_x : {false, true}) {
      for (const bool mirrored_y : {false, true}) {
        WrongSensor sensor([](const Force& f) { return f; },
                           [&](std::array<double, 2> at) {
                             if (mirrored_x) at[0] = -at[0];
                             if (mirrored_y) at[1] = -at[1];
                             if (transposed) std::swap(at[0], at[1]);
                             return at;
                           });
        Readings readings = sensor.all();
        const LayoutChange found = scales_of(kPad, kWeights, readings).layout.value();
        EXPECT_EQ(found.transposed, transposed);
        EXPECT_EQ(found.mirrored_x, mirrored_x) << "after the exchange";
        EXPECT_EQ(found.mirrored_y, mirrored_y) << "after the exchange";
        readings.erase(Step::corner_x);
        EXPECT_FALSE(scales_of(kPad, kWeights, readings).layout->transposed) << "one corner does not tell";
      }
    }
  }
}

TEST(Calibration, RefusesMotionNoiseAndForcesOnTwoAxes) {
  WrongSensor sensor([](const Force& f) { return f; });
  Readings moved = sensor.all();
  moved[Step::normal] = sensor.read({0, 0, 2}, {}, 0.2);
  EXPECT_THAT(refusal(kPad, kWeights, moved), HasSubstr("step normal was not still"));
  Readings drifting = sensor.all();
  drifting[Step::zero] = sensor.read({0, 0, 1}, {}, 0.5);
  EXPECT_THAT(refusal(kPad, kWeights, drifting), HasSubstr("step zero was not still"));
  Readings askew = sensor.all();
  askew[Step::shear_x] = sensor.read({1, 0.9, 0});
  EXPECT_THAT(refusal(kPad, kWeights, askew), HasSubstr("step shear-x: the force is read on two axes"));
  Readings same = sensor.all();
  same[Step::shear_y] = same[Step::shear_x];
  EXPECT_THAT(refusal(kPad, kWeights, same), HasSubstr("both read on x"));
  WrongSensor noisy([](const Force& f) { return f; }, [](auto at) { return at; }, 3);
  EXPECT_THAT(refusal(kPad, kWeights, noisy.all()), HasSubstr("too little beside the noise"));
  WrongSensor dead([](const Force&) { return Force{}; }, [](auto at) { return at; }, 0);
  EXPECT_THAT(refusal(kPad, kWeights, dead.all()), HasSubstr("too little beside the noise"));
  Readings middle = sensor.all();
  middle[Step::corner] = sensor.read({0, 0, 2}, {0, 0});
  EXPECT_THAT(refusal(kPad, kWeights, middle), HasSubstr("in the middle of the pad"));
}

TEST(Calibration, RefusesAPullThatAPreloadHides) {
  WrongSensor deaf([](const Force& f) { return Force{0, 0, f[2]}; });
  EXPECT_THAT(refusal(kPad, kWeights, deaf.all(5)), HasSubstr("step shear-x"));
}

TEST(Calibration, RefusesPullsOfASensorWithoutShear) {
  WrongSensor sensor([](const Force& f) { return f; });
  EXPECT_THAT(refusal({SensorClass::normal, {-6, -6}, {6, 6}}, kWeights, sensor.all()),
              HasSubstr("measures no shear"));
  EXPECT_THAT(refusal(kPad, kWeights, {{Step::zero, sensor.read({})}}), HasSubstr("step normal is missing"));
}

std::string report_of(const std::string& driver, const WrongSensor::ReadForce& wrong) {
  WrongSensor sensor(
      wrong, [](auto at) { return at; }, 1e-6);
  return report({"left", driver, kPad, true}, kWeights, scales_of(kPad, kWeights, sensor.all()));
}

TEST(CalibrationReport, GivesEachLineAPlaceThatExists) {
  const auto twice = [](const Force& f) { return Force{2 * f[0], 2 * f[1], 2 * f[2]}; };
  const auto uneven = [](const Force& f) { return Force{f[0] / 2, f[1] / 4, f[2]}; };
  const auto turned = [](const Force& f) { return Force{-f[1], f[0], f[2]}; };
  for (const char* driver : {"can", "sim"})
    EXPECT_THAT(report_of(driver, twice), AllOf(HasSubstr("\"gain\": 0.5\n"), Not(HasSubstr("scale\":"))));
  EXPECT_THAT(report_of("push", twice), HasSubstr("\"options\": { \"scale\": 0.5 }"));
  EXPECT_THAT(report_of("push", uneven), HasSubstr("\"options\": { \"scale\": [2, 4, 1] }"));
  EXPECT_THAT(report_of("can", uneven),
              AllOf(HasSubstr("\"axis\": \"x\": times 2\n"), HasSubstr("\"axis\": \"y\": times 4\n"),
                    HasSubstr("scale_pa")));
  EXPECT_THAT(report_of("can", turned),
              HasSubstr("\"axes\": { \"normal\": \"z\", \"x\": \"y\", \"y\": \"-x\" }"));
  EXPECT_THAT(report_of("push", turned), AllOf(HasSubstr("x is what now is y, y is what now is x"),
                                               HasSubstr("\"options\": { \"scale\": [1, -1, 1] }")));
  EXPECT_THAT(report_of("sim", uneven), HasSubstr("no key for that"));
}

TEST(CalibrationReport, GivesNoGainToValuesThatAreNotCalibrated) {
  WrongSensor sensor([](const Force& f) { return Force{2 * f[0], 2 * f[1], 2 * f[2]}; });
  const Scales scales = scales_of(kPad, kWeights, sensor.all());
  EXPECT_THAT(report({"left", "can", kPad, false}, kWeights, scales),
              AllOf(Not(HasSubstr("\"gain\"")), HasSubstr("\"axis\": \"z\": times 0."),
                    HasSubstr("\"calibrated\": false"), HasSubstr("the zero")));
}

TEST(CalibrationReport, SaysWhatItCouldNotKnow) {
  WrongSensor sensor([](const Force& f) { return f; });
  Readings readings = sensor.all();
  for (const Step step : {Step::shear_x, Step::shear_y, Step::corner, Step::corner_x}) readings.erase(step);
  const std::string text = report({"left", "push", kPad, true}, {2, 0}, scales_of(kPad, {2, 0}, readings));
  EXPECT_THAT(text, AllOf(HasSubstr("no weight pulled"), HasSubstr("--corner tells"), HasSubstr("how true")));
}

TEST(CalibrationReading, OutlivesAFile) {
  WrongSensor sensor([](const Force& f) { return f; });
  const Reading reading = sensor.read({1, 2, 3}, {4, 5});
  EXPECT_EQ(to_json(reading_from(to_json(reading))), to_json(reading));
}

TEST(CalibrationWeight, HasAUnit) {
  EXPECT_DOUBLE_EQ(force_of("200g"), 1.96133);
  EXPECT_DOUBLE_EQ(force_of("0.2 kg"), 1.96133);
  EXPECT_DOUBLE_EQ(force_of("1.5N"), 1.5);
  for (const char* wrong : {"", "g", "200", "-1g", "0N", "1lb", "200gg", "nan g"})
    EXPECT_THROW(force_of(wrong), std::invalid_argument) << wrong;
}

}  // namespace
}  // namespace slipctl::calibration
