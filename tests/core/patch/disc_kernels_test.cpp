// The loops over taxels give the same sums on every instruction set, and the same as plain sums in double.
#include "core/patch/disc_kernels.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

// Channels and positions of `size` taxels; zeros follow where there are fewer than a block.
struct Taxels {
  std::vector<float> normal, shear_x, shear_y, x, y;
  std::size_t size;

  Taxels(std::size_t count, std::uint32_t seed) : size(count) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> pressure(-2e3F, 1e5F), shear(-5e4F, 5e4F), place(-8e-3F, 8e-3F);
    for (std::size_t i = 0; i < count; ++i) {
      normal.push_back(pressure(random));
      shear_x.push_back(shear(random));
      shear_y.push_back(shear(random));
      x.push_back(place(random));
      y.push_back(place(random));
    }
    for (auto* list : {&normal, &shear_x, &shear_y, &x, &y})
      list->resize(std::max<std::size_t>(count, TaxelView::kLanes));
  }
  TaxelView view() const { return {normal.data(), shear_x.data(), shear_y.data(), x.data(), y.data(), size}; }
};

std::vector<TaxelRun> random_runs(std::size_t size, std::mt19937& random) {
  std::vector<TaxelRun> runs;
  std::uniform_int_distribution<std::uint32_t> gap(0, 9), length(1, 60);
  for (std::uint32_t at = gap(random); at < size;) {
    const std::uint32_t end = std::min<std::uint32_t>(at + length(random), static_cast<std::uint32_t>(size));
    runs.push_back({at, end});
    at = end + 1 + gap(random);
  }
  return runs;
}

// A sum of terms. The kernels' result must be within 1e-6 of the sum of the terms' magnitudes.
class Near {
 public:
  void add(double value) { add(value, std::fabs(value)); }
  void add(double value, double size) {  // size: the magnitude of a value that is itself a sum
    sum_ += value;
    size_ += size;
  }
  void expect(double said, const char* what, const char* kernels) const {
    EXPECT_NEAR(said, sum_, 1e-6 * size_) << what << ", " << kernels;
  }

 private:
  double sum_ = 0, size_ = 0;
};

const ContactPose kFrom{
    .x_m = 4e-4F, .y_m = -1.1e-3F, .direction_x = 0.6F, .direction_y = -0.8F, .radius_m = 5e-3F};

class DiscKernelsOf : public ::testing::TestWithParam<std::size_t> {};

constexpr float kLeastPa = 3e4F;
constexpr DeadTaxelTest kDeadTaxel{.below_pa = 1e4F, .within_m2 = 2e-5F};

// The sums of the kernels, taxel by taxel in double.
struct PlainSums {
  Near noise, squares;
  std::size_t below = 0, dead_taxels = 0;
  float peak = 0, inner_peak = 0;
  std::array<Near, 4> placed, weighed;
  std::array<Near, 4> force;
  Near distances;
  std::array<Near, 14> moments;
};

template <std::size_t N>
void add(std::array<Near, N>& sums, const std::array<double, N>& values) {
  for (std::size_t k = 0; k < N; ++k) sums[k].add(values[k]);
}

template <std::size_t N>
void expect(const std::array<Near, N>& sums, const std::array<double, N>& values, const char* what,
            const char* kernels) {
  for (std::size_t k = 0; k < N; ++k) sums[k].expect(values[k], what, kernels);
}

void add_frame(const TaxelView& view, PlainSums& sums) {
  for (std::size_t i = 0; i < view.size; ++i) {
    const double p = view.normal_pa[i], x = view.x_m[i], y = view.y_m[i];
    if (p < 0) sums.noise.add(p * p);
    sums.below += p < 0 ? 1 : 0;
    sums.peak = std::max(sums.peak, view.normal_pa[i]);
    const double counted = view.normal_pa[i] < kLeastPa ? 0 : p;
    add(sums.placed, {counted, counted * x, counted * y, counted * (x * x + y * y)});
  }
}

void add_taxel_of_disc(const TaxelView& view, std::size_t i, PlainSums& sums) {
  const double p = view.normal_pa[i], sx = view.shear_x_pa[i], sy = view.shear_y_pa[i];
  const double x = view.x_m[i] - kFrom.x_m, y = view.y_m[i] - kFrom.y_m, rr = x * x + y * y;
  const double q = kFrom.direction_x * sx + kFrom.direction_y * sy;
  const double a2 = static_cast<double>(kFrom.radius_m) * kFrom.radius_m, s = rr / a2;
  sums.inner_peak = std::max(sums.inner_peak, view.normal_pa[i]);
  add(sums.weighed, {p, p * x, p * y, p * rr});
  add(sums.force, {p, sx, sy, 0});
  sums.force[3].add(x * sy - y * sx, std::fabs(x * sy) + std::fabs(y * sx));
  sums.distances.add(rr);
  add(sums.moments, {p, q, p * s, q * s, q * s * s, s, s * s, s * s * s, s * s * s * s, p * s * s, p * s * x,
                     p * s * y, p * (x * x - y * y) / a2, p * x * y / a2});
  sums.squares.add(q * q);
  sums.dead_taxels += view.normal_pa[i] < kDeadTaxel.below_pa && rr < kDeadTaxel.within_m2 ? 1 : 0;
}

PlainSums plain_sums(const TaxelView& view, std::span<const TaxelRun> runs) {
  PlainSums sums;
  add_frame(view, sums);
  for (const auto& run : runs) {
    for (std::size_t i = run.first; i < run.end; ++i) add_taxel_of_disc(view, i, sums);
  }
  return sums;
}

void expect_agreement(const DiscKernels& kernels, const TaxelView& view, std::span<const TaxelRun> runs,
                      const PlainSums& plain) {
  const char* const name = kernels.name;
  const NoiseSums noise = kernels.noise(view);
  plain.noise.expect(noise.squares, "noise", name);
  EXPECT_EQ(noise.below, plain.below) << name;
  EXPECT_EQ(noise.peak, plain.peak) << name;
  const PlaceSums placed = kernels.place(view, kLeastPa);
  expect(plain.placed, {placed.p, placed.px, placed.py, placed.prr}, "place", name);
  const PlaceSums weighed = kernels.weigh(view, runs, kFrom.x_m, kFrom.y_m, kDeadTaxel);
  expect(plain.weighed, {weighed.p, weighed.px, weighed.py, weighed.prr}, "weigh", name);
  EXPECT_EQ(weighed.dead_taxels, plain.dead_taxels) << name;
  const ForceSums force = kernels.force(view, runs, kFrom.x_m, kFrom.y_m);
  expect(plain.force, {force.p, force.x, force.y, force.moment}, "force", name);
  plain.distances.expect(force.rr, "distances", name);
  EXPECT_EQ(force.peak, plain.inner_peak) << name;
  plain.squares.expect(kernels.shear_squares(view, runs, kFrom), "squares of shear", name);
  const MomentSums m = kernels.moments(view, runs, kFrom);
  expect(plain.moments,
         {m.p, m.q, m.ps, m.qs, m.qss, m.s, m.s2, m.s3, m.s4, m.pss, m.psx, m.psy, m.px2y2, m.pxy}, "moments",
         name);
}

TEST_P(DiscKernelsOf, AgreeWithPlainSums) {
  std::mt19937 random(7);
  for (std::uint32_t seed = 0; seed < 5; ++seed) {
    const Taxels taxels(GetParam(), seed);
    const TaxelView view = taxels.view();
    const auto runs = random_runs(GetParam(), random);
    const PlainSums plain = plain_sums(view, runs);
    for (const DiscKernels* kernels : kernels_at_hand<DiscKernels>()) {
      expect_agreement(*kernels, view, runs, plain);
    }
  }
}

// Rounding may put a taxel on the border of two rings into either. The test therefore compares what all
// rings up to a border hold together.
TEST_P(DiscKernelsOf, LeaveNoTaxelOutOfTheRings) {
  constexpr std::size_t kRings = 16;
  std::mt19937 random(8);
  const Taxels taxels(GetParam(), 11);
  const TaxelView view = taxels.view();
  const auto runs = random_runs(GetParam(), random);
  for (const DiscKernels* kernels : kernels_at_hand<DiscKernels>()) {
    std::array<RingSums, kRings> rings{};
    kernels->rings(view, runs, kFrom, kRings, rings.data());
    std::array<double, kRings> count{};
    Near p, q;
    for (const auto& run : runs) {
      for (std::size_t i = run.first; i < run.end; ++i) {
        const double r = std::hypot(view.x_m[i] - kFrom.x_m, view.y_m[i] - kFrom.y_m) / kFrom.radius_m;
        count[std::min(static_cast<std::size_t>(r * kRings), kRings - 1)] += 1;
        p.add(view.normal_pa[i]);
        const double along = static_cast<double>(kFrom.direction_x) * view.shear_x_pa[i],
                     across = static_cast<double>(kFrom.direction_y) * view.shear_y_pa[i];
        q.add(along + across, std::fabs(along) + std::fabs(across));
      }
    }
    double all_p = 0, all_q = 0;
    for (std::size_t j = 0; j < kRings; ++j) {
      all_p += rings[j].p;
      all_q += rings[j].q;
      EXPECT_NEAR(rings[j].taxels, count[j], 1) << kernels->name << ", ring " << j;
    }
    p.expect(all_p, "pressure", kernels->name);
    q.expect(all_q, "shear", kernels->name);
  }
}

TEST_P(DiscKernelsOf, AddRowsOfValuesAndOfTheirMoments) {
  const Taxels taxels(GetParam(), 12);
  for (const DiscKernels* kernels : kernels_at_hand<DiscKernels>()) {
    std::vector<float> sums(GetParam() + 1, 1.0F), moments(GetParam() + 1, 2.0F);
    kernels->add_row(taxels.normal.data(), GetParam(), 3, sums.data(), moments.data());
    for (std::size_t i = 0; i < GetParam(); ++i) {
      EXPECT_FLOAT_EQ(sums[i], 1 + taxels.normal[i]) << kernels->name;
      EXPECT_FLOAT_EQ(moments[i], 2 + 3 * taxels.normal[i]) << kernels->name;
    }
    EXPECT_EQ(sums.back(), 1) << kernels->name << ": beyond the row";
    EXPECT_EQ(moments.back(), 2) << kernels->name << ": beyond the row";
  }
}

// Fewer than a block, one block, not a multiple of a block, and the layout of docs/theory.md's paper.
INSTANTIATE_TEST_SUITE_P(Layouts, DiscKernelsOf, ::testing::Values(1, 9, 16, 17, 100, 1000, 10000));

TEST(DiscKernels, TheFastestOfThisProcessorAreChosen) {
  EXPECT_EQ(&best_kernels<DiscKernels>(), kernels_at_hand<DiscKernels>().back());
}

}  // namespace
}  // namespace slipd
