// The sums that fits are made of are the same on every instruction set, and the same as plain sums.
#include "core/reading/fit/normal_equations/dome_products.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <vector>

#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

// Lists of exactly so many values: a loop that reads beyond them is seen by AddressSanitizer.
struct Lists {
  std::array<std::vector<double>, 10> list;
  std::size_t count;

  Lists(std::size_t values, std::mt19937_64& random) : count(values) {
    std::uniform_real_distribution<double> value(-1, 1);
    for (auto& each : list) {
      for (std::size_t i = 0; i < count; ++i) each.push_back(value(random));
    }
  }
  DomeTask task() const {
    const auto at = [&](std::size_t i) { return list[i].data(); };
    return {.contact = {at(0), at(1), at(2), at(3)},
            .stick = {at(4), at(5), at(6), at(7)},
            .normal_pa = at(8),
            .shear_pa = at(9),
            .count = count,
            .stick_share = 0.7};
  }
};

TEST(DomeProducts, AreThoseOfPlainSumsOnEveryInstructionSet) {
  std::mt19937_64 random(3);
  for (const std::size_t count : {1U, 7U, 8U, 9U, 16U, 25U, 131U}) {
    const Lists lists(count, random);
    const DomeTask task = lists.task();
    double oo = 0, op = 0, dd = 0, dq = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double o = task.contact.value[i], d = o - task.stick.value[i];
      oo += o * o;
      op += o * task.normal_pa[i];
      dd += d * d;
      dq += d * task.shear_pa[i];
    }
    const DomeHeights expected{op / oo, dq / dd};
    DomeProducts sums;
    const auto add = [](const auto& row, auto& to) {
      std::size_t pair = 0;
      for (std::size_t a = 0; a < row.size(); ++a) {
        for (std::size_t b = 0; b <= a; ++b) to[pair++] += row[a] * row[b];
      }
    };
    for (std::size_t i = 0; i < count; ++i) {
      const DomePointers &o = task.contact, &s = task.stick;
      const double d = o.value[i] - s.value[i];
      add(std::array{o.d_u[i], o.d_v[i], o.d_x[i], o.value[i],
                     expected.pressure * o.value[i] - task.normal_pa[i]},
          sums.pressure);
      add(std::array{o.d_u[i] - s.d_u[i], o.d_v[i] - s.d_v[i], o.d_x[i] - task.stick_share * s.d_x[i], d,
                     s.d_x[i], expected.shear * d - task.shear_pa[i]},
          sums.shear);
    }
    for (const DomeProductKernels* kernels : kernels_at_hand<DomeProductKernels>()) {
      const DomeHeights heights = kernels->heights(task);
      EXPECT_NEAR(heights.pressure, expected.pressure, 1e-12 * (1 + std::fabs(expected.pressure)));
      EXPECT_NEAR(heights.shear, expected.shear, 1e-12 * (1 + std::fabs(expected.shear)));
      DomeProducts products;
      kernels->products(task, expected, products);
      // Rounding of sums of so many terms, each of the order of the heights squared.
      const double scale = 1e-13 * static_cast<double>(count) *
                           (1 + expected.pressure * expected.pressure + expected.shear * expected.shear);
      for (std::size_t i = 0; i < sums.pressure.size(); ++i)
        EXPECT_NEAR(products.pressure[i], sums.pressure[i], scale) << count << " " << i;
      for (std::size_t i = 0; i < sums.shear.size(); ++i)
        EXPECT_NEAR(products.shear[i], sums.shear[i], scale) << count << " " << i;
    }
  }
}

TEST(DomeProducts, NoSampleInTheContactHasNoHeight) {
  const std::vector<double> zeros(5), data(5, 1.0);
  const DomePointers nothing{zeros.data(), zeros.data(), zeros.data(), zeros.data()};
  for (const DomeProductKernels* kernels : kernels_at_hand<DomeProductKernels>()) {
    const DomeHeights heights = kernels->heights({.contact = nothing,
                                                  .stick = nothing,
                                                  .normal_pa = data.data(),
                                                  .shear_pa = data.data(),
                                                  .count = data.size()});
    EXPECT_FALSE(std::isfinite(heights.pressure));
    EXPECT_FALSE(std::isfinite(heights.shear));
  }
}

}  // namespace
}  // namespace slipd
