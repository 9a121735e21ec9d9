// The loops over taxels that slip, on every instruction set, against the same sums in double precision.
#include "core/reading/torque/torque_kernels.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

constexpr std::size_t kTaxels = 700;

struct RandomTaxels {
  RandomTaxels() {
    std::mt19937_64 random(6);
    std::uniform_real_distribution<float> unit(-1, 1);
    for (std::size_t i = 0; i < kTaxels; ++i) {
      normal.push_back(1e5F * unit(random));
      shear_x.push_back(4e4F * unit(random));
      shear_y.push_back(4e4F * unit(random));
      x.push_back(4e-3F * unit(random));
      y.push_back(4e-3F * unit(random));
    }
  }
  TaxelView view() const {
    return {normal.data(), shear_x.data(), shear_y.data(), x.data(), y.data(), kTaxels};
  }
  std::vector<float> normal, shear_x, shear_y, x, y;
  // Shorter than a register, longer, and up to the last taxel.
  std::vector<TaxelRun> runs{{3, 5}, {20, 61}, {100, 116}, {130, 400}, {450, 451}, {600, kTaxels}};
};

struct Lists {
  std::vector<float> pressure = std::vector<float>(kTaxels + 6 * kMaxLanes),
                     ratio = std::vector<float>(kTaxels + 6 * kMaxLanes);
};

const RatioTest kTest{.least_pa = 2e4F, .rectified_pa2 = 1e7F};

class TurningKernelsOn : public ::testing::TestWithParam<const TorqueKernels*> {};

TEST_P(TurningKernelsOn, CollectThePressureAndRatioOfEveryOtherRun) {
  const RandomTaxels taxels;
  for (const std::size_t stride : {1, 2, 4}) {
    Lists lists;
    const RatioSums found = GetParam()->ratios(taxels.view(), taxels.runs, stride, kTest,
                                               lists.pressure.data(), lists.ratio.data());
    double normal_pa = 0, below_pa = 0;
    std::vector<double> ratios;
    for (std::size_t run = 0; run < taxels.runs.size(); run += stride) {
      for (std::uint32_t i = taxels.runs[run].first; i < taxels.runs[run].end; ++i) {
        const double p = taxels.normal[i], x = taxels.shear_x[i], y = taxels.shear_y[i];
        if (!(p > 2e4)) continue;
        ratios.push_back(std::sqrt(std::max(0.0, x * x + y * y - 1e7)) / p);
        normal_pa += p;
        below_pa += ratios.back() < 0.4 ? p : 0;
      }
    }
    ASSERT_EQ(found.taxels, ratios.size());
    EXPECT_NEAR(found.normal_pa, normal_pa, 1e-6 * normal_pa);
    EXPECT_NEAR(GetParam()->below(lists.pressure.data(), lists.ratio.data(), found.stored, 0.4F), below_pa,
                1e-6 * normal_pa);
    std::size_t at = 0;
    for (std::size_t i = 0; i < found.stored; ++i) {
      if (lists.pressure[i] == 0) continue;
      ASSERT_LT(at, ratios.size());
      EXPECT_NEAR(static_cast<double>(lists.ratio[i]), ratios[at], 1e-5 * (1 + ratios[at]));
      ++at;
    }
    EXPECT_EQ(at, ratios.size());
  }
}

TEST_P(TurningKernelsOn, SumUpThePlateauWithoutNoiseAsWell) {
  const RandomTaxels taxels;
  for (const float noise_pa2 : {0.0F, 4e6F}) {
    const PlateauTest test{.ratio = 0.5F, .noise_pa2 = noise_pa2, .gain = 1e-3F, .within = 4};
    Lists lists;
    const RatioSums found =
        GetParam()->ratios(taxels.view(), taxels.runs, 1, kTest, lists.pressure.data(), lists.ratio.data());
    PlateauSums truth;
    for (std::size_t i = 0; i < found.stored; ++i) {
      const double p = lists.pressure[i], off = static_cast<double>(lists.ratio[i]) - 0.5;
      const double variance = static_cast<double>(noise_pa2) / (p * p) + static_cast<double>(test.gain);
      if (p == 0 || !(off * off < 4 * variance)) continue;
      const double weight = 1 / variance;
      ++truth.taxels;
      truth.weight += weight;
      truth.off += weight * off;
      truth.width += std::sqrt(weight);
      truth.normal_pa += p;
      truth.p += weight * p;
      truth.pp += weight * p * p;
      truth.p_off += weight * p * off;
    }
    ASSERT_GT(truth.taxels, 10U);
    const PlateauSums all =
        GetParam()->plateau(lists.pressure.data(), lists.ratio.data(), found.stored, test);
    const PlateauSums near = GetParam()->near(lists.pressure.data(), lists.ratio.data(), found.stored, test);
    EXPECT_EQ(all.taxels, truth.taxels);
    EXPECT_EQ(near.taxels, truth.taxels);
    EXPECT_EQ(near.weight, all.weight);
    EXPECT_EQ(near.off, all.off);
    EXPECT_NEAR(all.weight / truth.weight, 1, 1e-5);
    EXPECT_NEAR(all.off, truth.off, 1e-5 * truth.weight);
    EXPECT_NEAR(all.width / truth.width, 1, 1e-5);
    EXPECT_NEAR(all.normal_pa / truth.normal_pa, 1, 1e-6);
    EXPECT_NEAR(all.p / truth.p, 1, 1e-5);
    EXPECT_NEAR(all.pp / truth.pp, 1, 1e-5);
    EXPECT_NEAR(all.p_off, truth.p_off, 1e-5 * truth.p);
  }
}

TEST_P(TurningKernelsOn, SumUpThePowerOfAMotion) {
  const RandomTaxels taxels;
  const ContactPose pose{
      .x_m = 1e-4F, .y_m = -2e-4F, .direction_x = 0.6F, .direction_y = 0.8F, .radius_m = 3e-3F};
  const TorqueSums found =
      GetParam()->turning(taxels.view(), taxels.runs, pose, {.along = 0.7F, .spin = -1.2F});
  double work[3] = {}, limit[3] = {}, speeds[3] = {}, sizes[3] = {};
  for (const TaxelRun& run : taxels.runs) {
    for (std::uint32_t i = run.first; i < run.end; ++i) {
      const double x = (static_cast<double>(taxels.x[i]) - 1e-4) / 3e-3;
      const double y = (static_cast<double>(taxels.y[i]) + 2e-4) / 3e-3, s = x * x + y * y;
      const double v_x = 0.7 * 0.6 + 1.2 * y, v_y = 0.7 * 0.8 - 1.2 * x, square = v_x * v_x + v_y * v_y;
      double power = 1;
      for (int n = 0; n < 3; ++n, power *= s) {
        work[n] += power * (taxels.shear_x[i] * v_x + taxels.shear_y[i] * v_y);
        limit[n] += power * taxels.normal[i] * std::sqrt(square);
        speeds[n] += power * square;
        sizes[n] += power * 1e5 * std::sqrt(square);
      }
    }
  }
  for (int n = 0; n < 3; ++n) {
    EXPECT_NEAR(found.work[n], work[n], 1e-6 * sizes[n]);
    EXPECT_NEAR(found.limit[n], limit[n], 1e-6 * sizes[n]);
    EXPECT_NEAR(found.speeds[n] / speeds[n], 1, 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, TurningKernelsOn,
                         ::testing::ValuesIn(kernels_at_hand<TorqueKernels>().begin(),
                                             kernels_at_hand<TorqueKernels>().end()),
                         [](const auto& tested) { return tested.param->name; });

}  // namespace
}  // namespace slipd
