#include "core/friction/foundations/winkler_foundations.hpp"

#include <algorithm>
#include <cmath>

#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

// The outermost spring's place over the contact's radius when springs are set; ratio, 1.05 … 3. Too small:
// springs are set anew at each growth, and each time interpolates. Too large: few springs touch. Checked with
// `slipd-lab histories --grasps 400`.
constexpr double kSpare = 1.2;
constexpr auto kSprings = WinklerKernels::kSprings;

constexpr float place(std::size_t i) noexcept {
  return static_cast<float>(i) + 0.5F;
}

// The sum over the springs that touch: the normal force as the springs see it.
float sum_of(const std::array<float, kSprings>& rest) noexcept {
  float sum = 0;
  for (const float r : rest) sum += r;
  return sum;
}

}  // namespace

WinklerFoundations::WinklerFoundations(std::span<const double> frictions) noexcept
    : WinklerFoundations(frictions, best_kernels<WinklerKernels>()) {}

WinklerFoundations::WinklerFoundations(std::span<const double> frictions,
                                       const WinklerKernels& kernels) noexcept
    : kernels_(&kernels),
      count_(std::min(frictions.size(), kMost)),
      vectors_((count_ + WinklerKernels::kLanes - 1) / WinklerKernels::kLanes) {
  friction_.fill(1);
  std::copy_n(frictions.begin(), count_, friction_.begin());
  std::transform(friction_.begin(), friction_.end(), mu_.begin(),
                 [](double mu) { return static_cast<float>(mu); });
}

void WinklerFoundations::clear() noexcept {
  step_ = normal_n_ = asked_n_ = 0;
  shear_n_.fill(0);
  loads_ = {};
  summed_ = false;
}

// Sets the springs wider when the contact has outgrown them.
void WinklerFoundations::reach(double radius) noexcept {
  if (radius <= step_ * static_cast<double>(kSprings)) return;
  const double step = kSpare * radius / static_cast<double>(kSprings), ratio = step_ > 0 ? step / step_ : 0;
  step_ = step;
  // Each is taken from further out: none is read after it is set.
  for (std::size_t i = 0; i < kSprings && ratio > 0; ++i) {
    const double at = ratio * (static_cast<double>(i) + 0.5) - 0.5;
    if (at >= static_cast<double>(kSprings - 1)) {
      loads_[i].fill(0);
      continue;
    }
    const auto low = static_cast<std::size_t>(std::max(0.0, at));
    const double part = std::max(0.0, at - static_cast<double>(low));
    for (std::size_t j = 0; j < kMost; ++j) {
      loads_[i][j] = static_cast<float>((1 - part) * static_cast<double>(loads_[low][j]) +
                                        part * static_cast<double>(loads_[low + 1][j]));
    }
  }
}

// The normal load of each spring: edge - x^2 where that is above 0.
WinklerFoundations::Rest WinklerFoundations::rests(double edge) const noexcept {
  const auto square = static_cast<float>(step_ * step_), outside = static_cast<float>(edge);
  Rest rest;
  for (std::size_t i = 0; i < kSprings; ++i) rest[i] = std::max(outside - square * place(i) * place(i), 0.0F);
  return rest;
}

void WinklerFoundations::settle(const Rest& rest, const PerBed<std::int32_t>& which) noexcept {
  const auto touching = static_cast<std::size_t>(
      std::find_if(rest.begin(), rest.end(), [](float r) { return r <= 0; }) - rest.begin());
  const double as_sensed_n = sum_of(rest);
  PerBed<float> goal;
  for (std::size_t j = 0; j < kMost; ++j) goal[j] = static_cast<float>(shear_n_[j] / normal_n_ * as_sensed_n);
  kernels_->settle(loads_[0].data(), rest.data(), touching, mu_.data(), goal.data(), which.data(), vectors_);
}

void WinklerFoundations::follow(double normal_n, double shear_n) noexcept {
  if (!(normal_n > 0)) {
    clear();
    return;
  }
  const double radius = std::cbrt(normal_n), edge = radius * radius, d_normal = normal_n - normal_n_;
  reach(radius);
  const Rest rest = rests(edge);
  PerBed<float> slope{};
  PerBed<std::int32_t> slips{};
  bool any_sticks = false, any_slips = false;
  for (std::size_t j = 0; j < count_; ++j) {
    const double most_n = friction_[j] * normal_n, target_n = std::clamp(shear_n, -most_n, most_n);
    const double d_shear = target_n - shear_n_[j];
    const bool sticks = d_normal > 0 && std::fabs(d_shear) <= friction_[j] * d_normal;
    slope[j] = sticks ? static_cast<float>(d_shear / d_normal) : 0;
    slips[j] = sticks ? 0 : -1;
    any_sticks |= sticks;
    any_slips |= !sticks;
    shear_n_[j] = target_n;
  }
  if (any_sticks) {  // the new ring takes its share
    const double old_radius = std::cbrt(normal_n_);
    Rest grown = rests(old_radius * old_radius);
    for (std::size_t i = 0; i < kSprings; ++i) grown[i] = rest[i] - grown[i];
    kernels_->stretch(loads_[0].data(), grown.data(), slope.data(), vectors_);
  }
  normal_n_ = normal_n;
  asked_n_ = shear_n;
  if (any_slips) settle(rest, slips);
  summed_ = false;
}

void WinklerFoundations::assume_monotonic(double normal_n, double shear_n) noexcept {
  clear();
  follow(normal_n, 0);
  follow(normal_n, shear_n);
}

void WinklerFoundations::take_over(std::size_t from, const PerBed<std::int32_t>& which) noexcept {
  if (!(normal_n_ > 0)) return;
  for (std::size_t j = 0; j < count_; ++j) {
    if (which[j] == 0) continue;
    for (auto& row : loads_) row[j] = row[from];
    const double most_n = friction_[j] * normal_n_;
    shear_n_[j] = std::clamp(asked_n_, -most_n, most_n);
  }
  const double radius = std::cbrt(normal_n_);
  settle(rests(radius * radius), which);
  summed_ = false;
}

// <u>_p = 2/5 sets the scale (u = r^2/a^2), so that what the springs are too coarse for cancels. A spring at
// x stands for 2 x^2 of <r^2> and 8/3 x^4 of <r^4>, over those of p.
void WinklerFoundations::sum_up() const noexcept {
  const double radius = std::cbrt(normal_n_);
  const Rest rest = rests(radius * radius);
  float p = 0, p2 = 0;
  for (std::size_t i = 0; i < kSprings; ++i) {
    p += rest[i];
    p2 += rest[i] * (place(i) * place(i));
  }
  PerBed<float> q, q2, q4;
  kernels_->sums(loads_[0].data(), q.data(), q2.data(), q4.data(), vectors_);
  const double newton = normal_n_ / p;
#pragma omp simd
  for (std::size_t j = 0; j < count_; ++j) {
    const double u = 0.4 * q2[j] / p2, u2 = 8.0 / 3 * 0.04 * q4[j] * (p / p2) * (p / p2);
    moments_.slip_n[j] = newton * (5.0 / 3 * q[j] - 2.5 * p * u);
    moments_.legendre_n[j] = newton * (6 * u2 - 6 * p * u + q[j]);
  }
  summed_ = true;
}

contact::ShearMoments WinklerFoundations::shear_moments(std::size_t j) const noexcept {
  if (!(normal_n_ > 0)) return {};
  if (!summed_) sum_up();
  return {moments_.slip_n[j], moments_.legendre_n[j]};
}

}  // namespace slipd
