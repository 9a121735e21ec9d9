// Partial slip under force and torque against Cattaneo and Mindlin, against frames of a boundary-element
// solver that shares no code with slipd (tests/data/force-and-torque*.bin), and against what holds for any
// load.
#include "core/contact/partial_slip.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "core/contact/averages.hpp"

namespace slipd::contact {
namespace {

constexpr std::size_t kAcross = PartialSlip::kAcross;

// Hertz with P = 1 N on the solver's grid, `radius` in cells.
PartialSlip::Cells hertz(double radius) {
  PartialSlip::Cells normal{};
  double sum = 0;
  for (std::size_t i = 0; i < normal.size(); ++i) {
    const double middle = (kAcross - 1) / 2.0;
    const double value = disc_average_exact(radius, static_cast<double>(i % kAcross) - middle,
                                            static_cast<double>(i / kAcross) - middle, 1);
    normal[i] = static_cast<float>(value);
    sum += value;
  }
  for (float& value : normal) value /= static_cast<float>(sum);
  return normal;
}

PlaneLoad sums_of(const PartialSlip& contact) {
  PlaneLoad sums;
  const double middle = (kAcross - 1) / 2.0, side = contact.side_m();
  for (std::size_t i = 0; i < PartialSlip::kCells; ++i) {
    const auto x = static_cast<double>(contact.shear_x_n()[i]),
               y = static_cast<double>(contact.shear_y_n()[i]);
    sums.shear_x_n += x;
    sums.shear_y_n += y;
    sums.torque_nm += side * ((static_cast<double>(i % kAcross) - middle) * y -
                              (static_cast<double>(i / kAcross) - middle) * x);
  }
  return sums;
}

void expect_within_friction(const PartialSlip& contact) {
  for (std::size_t i = 0; i < PartialSlip::kCells; ++i) {
    EXPECT_LE(std::hypot(contact.shear_x_n()[i], contact.shear_y_n()[i]),
              contact.limit_n()[i] * (1 + 1e-5F) + 1e-12F);
  }
}

// The whole of the load is carried, nowhere beyond friction, on a path without rule.
TEST(PartialSlip, CarriesTheLoadWithinFrictionOnAnyPath) {
  PartialSlip contact;
  contact.release(3e-4);
  const auto normal = hertz(11);
  const PlaneLoad path[] = {{0.1, 0, 0}, {0.2, 0.1, 1e-4}, {0.2, 0.1, 5e-4}, {-0.1, 0.2, 2e-4},
                            {0, 0, 0},   {0, 0, -6e-4},    {0.3, 0, -2e-4},  {0.3, -0.2, 0}};
  for (const PlaneLoad& load : path) {
    contact.carry(normal, 0.5, load);
    expect_within_friction(contact);
    const PlaneLoad sums = sums_of(contact);
    ASSERT_LT(contact.used_share(), 0.99);
    EXPECT_NEAR(sums.shear_x_n, load.shear_x_n, 1e-5);
    EXPECT_NEAR(sums.shear_y_n, load.shear_y_n, 1e-5);
    EXPECT_NEAR(sums.torque_nm, load.torque_nm, 1e-5 * 24 * 3e-4);
  }
}

TEST(PartialSlip, CarriesNoMoreThanTheLimitSurface) {
  PartialSlip contact;
  contact.release(3e-4);
  contact.carry(hertz(11), 0.5, {3, 4, 0});
  EXPECT_NEAR(contact.used_share(), 10, 0.01);
  EXPECT_NEAR(contact.carried().shear_x_n, 0.3, 0.002);
  EXPECT_NEAR(sums_of(contact).shear_y_n, 0.4, 0.002);
  expect_within_friction(contact);
}

// Root mean square of the difference over that of the truth.
class Misfit {
 public:
  void add(double is, double should) {
    off_ += (is - should) * (is - should);
    all_ += should * should;
  }
  double share() const { return std::sqrt(off_ / all_); }

 private:
  double off_ = 0, all_ = 0;
};

// mu (D_a - D_c), docs/theory.md §3.1.
TEST(PartialSlip, IsCattaneosAndMindlinsUnderAPull) {
  constexpr double kRadius = 11, kFriction = 0.5;
  const auto normal = hertz(kRadius);
  for (const double gamma : {0.6, 0.3, 0.05}) {
    PartialSlip contact({.most_steps = 500});
    contact.release(3e-4);
    contact.carry(normal, kFriction, {kFriction * (1 - gamma), 0, 0});
    const double k = std::cbrt(gamma);
    const auto inner = hertz(k * kRadius);
    Misfit misfit;
    for (std::size_t i = 0; i < normal.size(); ++i) {
      misfit.add(
          static_cast<double>(contact.shear_x_n()[i]),
          kFriction * static_cast<double>(normal[i]) - kFriction * gamma * static_cast<double>(inner[i]));
      misfit.add(static_cast<double>(contact.shear_y_n()[i]), 0);
    }
    EXPECT_LT(misfit.share(), gamma > 0.5 ? 0.05 : 0.03) << gamma;
  }
}

// The referee's frames: 32 x 32 taxels of 0.45 mm, and the path of the load up to each.
struct Solved {
  double friction = 0, radius_m = 0, gamma = 0;
  std::vector<PlaneLoad> path;  // about the middle of the window
  PartialSlip::Cells normal_n{}, x_n{}, y_n{};
};

constexpr std::size_t kTaxels = 32;
constexpr double kSideM = 0.00045;

// The window of the solver's size that has the contact in it.
std::size_t corner_of(const std::vector<double>& along) {
  double sum = 0, moment = 0;
  for (std::size_t i = 0; i < along.size(); ++i) {
    sum += along[i];
    moment += along[i] * static_cast<double>(i);
  }
  const double first = moment / sum - (kAcross - 1) / 2.0;
  return static_cast<std::size_t>(std::clamp(std::lround(first), 0L, static_cast<long>(kTaxels - kAcross)));
}

std::vector<Solved> solved(const char* name, bool with_path) {
  constexpr double kFullCount = 32000, kArea = kSideM * kSideM;
  std::ifstream in(std::string(SLIPD_SOURCE_DIR "/tests/data/") + name, std::ios::binary);
  std::vector<Solved> all;
  std::array<double, 4> head{};
  while (in.read(reinterpret_cast<char*>(head.data()), sizeof head)) {
    Solved one{.friction = head[0], .radius_m = head[2], .gamma = 1 - head[1] / head[0], .path = {}};
    std::uint64_t steps = 0;
    if (with_path) in.read(reinterpret_cast<char*>(&steps), sizeof steps);
    std::vector<std::array<double, 3>> loads(steps);
    in.read(reinterpret_cast<char*>(loads.data()), static_cast<std::streamsize>(steps * sizeof loads[0]));
    std::vector<std::int16_t> counts(3 * kTaxels * kTaxels);
    in.read(reinterpret_cast<char*>(counts.data()), static_cast<std::streamsize>(2 * counts.size()));
    std::vector<double> columns(kTaxels), rows(kTaxels);
    for (std::size_t i = 0; i < kTaxels * kTaxels; ++i) {
      columns[i % kTaxels] += counts[i];
      rows[i / kTaxels] += counts[i];
    }
    const std::size_t left = corner_of(columns), bottom = corner_of(rows);
    for (std::size_t i = 0; i < PartialSlip::kCells; ++i) {
      const std::size_t taxel = (bottom + i / kAcross) * kTaxels + left + i % kAcross;
      const double unit = head[3] / kFullCount * kArea;
      one.normal_n[i] = static_cast<float>(unit * counts[taxel]);
      one.x_n[i] = static_cast<float>(unit * counts[kTaxels * kTaxels + taxel]);
      one.y_n[i] = static_cast<float>(unit * counts[2 * kTaxels * kTaxels + taxel]);
    }
    // The centre of pressure in the window; the file's torques are about it.
    double sum = 0, x_m = 0, y_m = 0;
    PlaneLoad load;
    for (std::size_t i = 0; i < PartialSlip::kCells; ++i) {
      const double u = (static_cast<double>(i % kAcross) - (kAcross - 1) / 2.0) * kSideM;
      const double v = (static_cast<double>(i / kAcross) - (kAcross - 1) / 2.0) * kSideM;
      const auto p = static_cast<double>(one.normal_n[i]), x = static_cast<double>(one.x_n[i]),
                 y = static_cast<double>(one.y_n[i]);
      sum += p;
      x_m += p * u;
      y_m += p * v;
      load.shear_x_n += x;
      load.shear_y_n += y;
      load.torque_nm += u * y - v * x;
    }
    for (const auto& [x, y, torque] : loads) one.path.push_back({x, y, torque + (x_m * y - y_m * x) / sum});
    if (!with_path) one.path.push_back(load);
    all.push_back(std::move(one));
  }
  return all;
}

struct Errors {
  double worst = 0, mean = 0;
};

Errors errors_of(const std::vector<Solved>& frames, const PartialSlipOptions& options) {
  Errors errors;
  for (const Solved& one : frames) {
    PartialSlip contact(options);
    contact.release(kSideM);
    for (const PlaneLoad& load : one.path) contact.carry(one.normal_n, one.friction, load);
    Misfit misfit;
    for (std::size_t i = 0; i < PartialSlip::kCells; ++i) {
      misfit.add(static_cast<double>(contact.shear_x_n()[i]), static_cast<double>(one.x_n[i]));
      misfit.add(static_cast<double>(contact.shear_y_n()[i]), static_cast<double>(one.y_n[i]));
    }
    EXPECT_NEAR(1 - contact.used_share(), one.gamma, 0.01);
    errors.worst = std::max(errors.worst, misfit.share());
    errors.mean += misfit.share() / static_cast<double>(frames.size());
  }
  return errors;
}

constexpr PartialSlipOptions kBed{.most_steps = 1};

// Tractions against the solver's, root mean squares over all taxels: mean and worst of the frames. Most of it
// is the rim's, where one grid sees what another does not.
constexpr double kMean = 0.04, kWorst = 0.08;

TEST(PartialSlip, IsTheSolversOnOneStraightLoad) {
  const auto frames = solved("force-and-torque.bin", false);
  ASSERT_GE(frames.size(), 12U);
  const Errors here = errors_of(frames, {.most_steps = 500}), bed = errors_of(frames, kBed);
  EXPECT_LT(here.mean, kMean);
  EXPECT_LT(here.worst, kWorst);
  // Why it is no bed of springs.
  EXPECT_GT(bed.mean, 5 * here.mean);
}

TEST(PartialSlip, IsTheSolversOnHistories) {
  const auto frames = solved("force-and-torque-histories.bin", true);
  ASSERT_GE(frames.size(), 5U);
  const Errors here = errors_of(frames, {}), bed = errors_of(frames, kBed);
  EXPECT_LT(here.mean, kMean);
  EXPECT_LT(here.worst, kWorst);
  // Why it is no bed of springs.
  EXPECT_GT(bed.mean, 5 * here.mean);
}

}  // namespace
}  // namespace slipd::contact
