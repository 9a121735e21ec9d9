// The filter from pressure sensed to what is sensed of a pull: against its definition summed directly, and
// against what the contact model's own stresses make taxels sense.
#include "core/reading/pressure_maps/shear_from_pressure_filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "core/contact/contact_field.hpp"
#include "tests/support/heap_count.hpp"
#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

struct SensedPull {
  explicit SensedPull(std::size_t size) : xx(size), xy(size), yy(size), nx(size), ny(size) {}
  ShearFromPressureFilter::Sensed spans() { return {xx, xy, yy, nx, ny}; }
  std::vector<float> xx, xy, yy, nx, ny;
};

std::vector<float> random_map(std::size_t size) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<float> out(size);
  for (float& value : out) value = unit(random);
  return out;
}

// Discrete Fourier transforms by their definition, on the grid with many empty taxels beside it. The highest
// frequency of an even number has either sign, so that its xy is 0.
struct DirectSum {
  TaxelLayout::Grid grid;
  double depth_m;
  enum Component { xx, xy, yy };

  double at(const std::vector<float>& map, std::size_t column, std::size_t row, Component component) const {
    const auto width = static_cast<int>(std::bit_ceil(8 * grid.columns)),
               height = static_cast<int>(std::bit_ceil(8 * grid.rows));
    std::complex<double> sum = 0;
    for (int u = -width / 2; u < width / 2; ++u) {
      for (int v = -height / 2; v < height / 2; ++v) {
        const double kx = 2 * std::numbers::pi * u / width, ky = 2 * std::numbers::pi * v / height;
        std::complex<double> spectrum = 0;
        for (std::size_t y = 0; y < grid.rows; ++y) {
          for (std::size_t x = 0; x < grid.columns; ++x) {
            const double behind = kx * (static_cast<double>(column) - static_cast<double>(x)) +
                                  ky * (static_cast<double>(row) - static_cast<double>(y));
            spectrum += static_cast<double>(map[y * grid.columns + x]) * std::polar(1.0, behind);
          }
        }
        const double d = depth_m / grid.pitch_m, k = std::hypot(kx, ky), per_k = k > 0 ? 1 / k : 0;
        const bool highest = u == -width / 2 || v == -height / 2;
        const double ratio = component == xx   ? 1 - d * kx * kx * per_k
                             : component == yy ? 1 - d * ky * ky * per_k
                             : highest         ? 0
                                               : -d * kx * ky * per_k;
        sum += spectrum * ratio / (1 + d * k);
      }
    }
    return sum.real() / (width * height);
  }
};

TEST(ShearFromPressureFilter, IsTheFilterOfItsDefinition) {
  for (const TaxelLayout::Grid& grid :
       {TaxelLayout::Grid{6, 5, 1e-3}, TaxelLayout::Grid{1, 4, 2e-3}, TaxelLayout::Grid{4, 4, 0.5e-3}}) {
    const DirectSum direct{grid, 1.3e-3};
    const std::vector<float> map = random_map(grid.columns * grid.rows);
    ShearFromPressureFilter ratio(grid, direct.depth_m);
    SensedPull sensed(map.size());
    ratio.apply(map, sensed.spans());
    for (std::size_t row = 0; row < grid.rows; row += 2) {
      for (std::size_t column = 0; column < grid.columns; column += 3) {
        const std::size_t i = row * grid.columns + column;
        EXPECT_NEAR(sensed.xx[i], direct.at(map, column, row, DirectSum::xx), 1e-5);
        EXPECT_NEAR(sensed.xy[i], direct.at(map, column, row, DirectSum::xy), 1e-5);
        EXPECT_NEAR(sensed.yy[i], direct.at(map, column, row, DirectSum::yy), 1e-5);
      }
    }
  }
}

TEST(ShearFromPressureFilter, ChangesNothingAtTheSurface) {
  const std::vector<float> map = random_map(35);
  ShearFromPressureFilter ratio({7, 5, 1e-3}, 0);
  SensedPull sensed(map.size());
  ratio.apply(map, sensed.spans());
  for (std::size_t i = 0; i < map.size(); ++i) {
    EXPECT_NEAR(sensed.xx[i], map[i], 1e-5);
    EXPECT_NEAR(sensed.xy[i], 0, 1e-5);
  }
}

TEST(ShearFromPressureFilter, AmplifiesNoNoise) {
  for (const double depth_m : {0.05e-3, 0.25e-3, 1e-3, 4e-3}) {
    const ShearFromPressureFilter ratio({32, 32, 0.5e-3}, depth_m);
    EXPECT_LT(ratio.noise_gain(), 1) << depth_m;
    EXPECT_GT(ratio.noise_gain(), 0.1) << depth_m;
    EXPECT_LT(ratio.pressing_gain(), 0.5) << depth_m;  // of two components, each at most 1
  }
}

// In the middle of the grid, where no noise from beyond is missing.
TEST(ShearFromPressureFilter, MakesOfNoiseAsMuchAsItSays) {
  constexpr std::size_t kSide = 96;
  ShearFromPressureFilter ratio({kSide, kSide, 0.5e-3}, 1e-3);
  const std::vector<float> map = random_map(kSide * kSide);
  SensedPull sensed(map.size());
  ratio.apply(map, sensed.spans());
  double shear = 0, pressure = 0, before = 0;
  for (std::size_t row = kSide / 4; row < 3 * kSide / 4; ++row) {
    for (std::size_t i = row * kSide + kSide / 4; i < row * kSide + 3 * kSide / 4; ++i) {
      before += map[i] * map[i];
      shear +=
          0.5 * (sensed.xx[i] * sensed.xx[i] + 2 * sensed.xy[i] * sensed.xy[i] + sensed.yy[i] * sensed.yy[i]);
      pressure += 0.5 * (sensed.nx[i] * sensed.nx[i] + sensed.ny[i] * sensed.ny[i]);
    }
  }
  EXPECT_NEAR(shear / before, ratio.noise_gain(), 0.05 * ratio.noise_gain());
  EXPECT_NEAR(pressure / before, ratio.pressing_gain(), 0.05 * ratio.pressing_gain());
}

// A contact that slides all over: its shear is friction times its pressure, and is sensed as pressure, too.
// The tolerance is what a grid of finite pitch and extent leaves.
TEST(ShearFromPressureFilter, MakesOfThePressureOfAContactWhatIsSensedOfItsPull) {
  const TaxelLayout layout = TaxelLayout::grid(32, 32, 0.5e-3);
  for (const double depth_m : {0.5e-3, 1e-3, 2e-3}) {
    contact::ContactField sheet(layout, {.depth_m = depth_m, .stretch = 1.5, .angle_rad = 0.4});
    contact::LoadHistory pressed(synthetic::paper_pair());
    pressed.move_to(3, 0, 0.5);
    contact::LoadHistory sliding = pressed;
    sliding.move_to(3, 1.5, 0.5);
    const std::size_t n = layout.size();
    std::vector<float> p(n), x(n), y(n), p2(n), x2(n), y2(n);
    sheet.sense(pressed, 0.6e-3, -0.9e-3, 0, p, x, y);
    constexpr double kPull_rad = 0.7;
    sheet.sense(sliding, 0.6e-3, -0.9e-3, kPull_rad, p2, x2, y2);
    ShearFromPressureFilter ratio(layout.regular().value(), depth_m);
    SensedPull sensed(n);
    ratio.apply(p, sensed.spans());
    const double qx = 0.5 * std::cos(kPull_rad), qy = 0.5 * std::sin(kPull_rad);
    const double most = 0.5 * static_cast<double>(*std::max_element(p.begin(), p.end()));
    double off = 0;
    for (std::size_t i = 0; i < n; ++i) {
      off = std::max(off, std::fabs(qx * sensed.xx[i] + qy * sensed.xy[i] - (x2[i] - x[i])));
      off = std::max(off, std::fabs(qx * sensed.xy[i] + qy * sensed.yy[i] - (y2[i] - y[i])));
      off = std::max(off, std::fabs(qx * sensed.nx[i] + qy * sensed.ny[i] - (p2[i] - p[i])));
    }
    EXPECT_LT(off, 0.005 * most) << depth_m;
    RecordProperty("off at " + std::to_string(depth_m), std::to_string(off / most));
  }
}

TEST(ShearFromPressureFilter, AllocatesNothing) {
  const std::vector<float> map = random_map(64);
  ShearFromPressureFilter ratio({8, 8, 1e-3}, 1e-3);
  SensedPull sensed(map.size());
  const std::uint64_t before = test::allocations();
  ratio.apply(map, sensed.spans());
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace slipd
