// The noise of a sensor that nothing touches, measured over time.
#include "core/patch/unloaded_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace slipd {
namespace {

constexpr double kSide_m = 0.007;
constexpr double kPerFrame_s = 0.002;
constexpr double kUnloaded_n = 0.1;

// Nine taxels. Each flickers on its own, and all share a part.
class Sensor {
 public:
  Sensor(double own_pa, double shared_pa) : own_(0, own_pa), shared_(0, shared_pa) {}
  const TaxelLayout& layout() const { return layout_; }
  Frame frame(double load_pa) {
    const double shared = shared_(random_);
    for (std::size_t i = 0; i < layout_.size(); ++i) {
      p_[i] = static_cast<float>(load_pa + shared + own_(random_));
      x_[i] = static_cast<float>(own_(random_));
      y_[i] = static_cast<float>(own_(random_));
    }
    ++sequence_;
    const auto time_ns = static_cast<std::int64_t>(1e9 * kPerFrame_s * static_cast<double>(sequence_));
    return {.sequence = sequence_,
            .time_ns = time_ns,
            .normal_pa = p_,
            .shear_x_pa = x_,
            .shear_y_pa = y_,
            .zeroed = true};
  }

 private:
  TaxelLayout layout_ = TaxelLayout::grid(3, 3, kSide_m);
  std::mt19937_64 random_{4};
  std::normal_distribution<double> own_, shared_;
  std::vector<float> p_ = std::vector<float>(9), x_ = p_, y_ = p_;
  std::uint64_t sequence_ = 0;
};

TEST(UnloadedNoise, IsThatOfTheTaxelsAndOfTheirSums) {
  Sensor sensor(100, 50);
  UnloadedNoise noise(sensor.layout(), kUnloaded_n);
  EXPECT_FALSE(noise.now());
  for (int i = 0; i < 2000; ++i) noise.update(sensor.frame(0));
  ASSERT_TRUE(noise.now());
  EXPECT_NEAR(noise.now()->normal_pa, std::hypot(100, 50), 5);
  EXPECT_NEAR(noise.now()->shear_pa, 100, 4);
  const double area_m2 = sensor.layout().area_m2();
  EXPECT_NEAR(noise.now()->normal_n / area_m2, std::hypot(3 * 100, 9 * 50), 40)
      << "what taxels share does not average out";
  EXPECT_NEAR(noise.now()->shear_n / area_m2, 3 * 100, 30);
}

TEST(UnloadedNoise, LeavesOutLoadsAndWhatComesJustBeforeThem) {
  Sensor sensor(100, 0);
  UnloadedNoise noise(sensor.layout(), kUnloaded_n);
  for (int grasp = 0; grasp < 20; ++grasp) {
    for (int i = 0; i < 500; ++i) noise.update(sensor.frame(i < 470 ? 0 : 200));  // it approaches
    for (int i = 0; i < 500; ++i) noise.update(sensor.frame(1e5));
  }
  EXPECT_NEAR(noise.now()->normal_pa, 100, 5);
}

TEST(UnloadedNoise, IsNotKnownOfASensorThatReadsExactlyZero) {
  Sensor sensor(0, 0);
  UnloadedNoise noise(sensor.layout(), kUnloaded_n);
  for (int i = 0; i < 2000; ++i) noise.update(sensor.frame(0));
  EXPECT_FALSE(noise.now());
}

}  // namespace
}  // namespace slipd
