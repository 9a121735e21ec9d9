#include "core/friction/foundations/winkler_foundations.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/contact/hertz.hpp"
#include "core/numeric/iteration.hpp"
#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

constexpr auto kSprings = WinklerKernels::kSprings;

constexpr float place(std::size_t i) noexcept {
  return static_cast<float>(i) + 0.5F;
}

double square(double x) noexcept {
  return x * x;
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
  std::transform(friction_.begin(), friction_.end(), inverse_.begin(), [](double mu) { return 1 / mu; });
  copy_of_.fill(kNone);
}

void WinklerFoundations::clear() noexcept {
  step_ = normal_n_ = asked_n_ = 0;
  pressed_ = {};
  carried_n_.fill(0);
  loads_ = {};
  taken_over_ = {};
  copy_of_.fill(kNone);
  summed_ = false;
}

// Sets the springs wider when the contact has outgrown them.
void WinklerFoundations::reach(double radius) noexcept {
  if (radius <= step_ * static_cast<double>(kSprings)) return;
  const double step = contact::kSpare * radius / static_cast<double>(kSprings),
               ratio = step_ > 0 ? step / step_ : 0;
  step_ = step;
  pressed_ = pressed_by(std::cbrt(normal_n_));
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

// Each spring's load is radius^2 - x^2 where that is above 0.
WinklerFoundations::Pressed WinklerFoundations::pressed_by(double radius) const noexcept {
  const auto unit = static_cast<float>(square(step_)), edge = static_cast<float>(square(radius));
  Pressed out;
#pragma omp simd
  for (std::size_t i = 0; i < kSprings; ++i) out.rest[i] = std::max(edge - unit * place(i) * place(i), 0.0F);
  for (const float rest : out.rest) {
    out.sum += rest;
    out.touching += rest > 0 ? 1 : 0;
  }
  return out;
}

// far: more than a spring's shift, as it carries at most what it could before.
void WinklerFoundations::settle(const PerBed<std::int32_t>& which, double far) noexcept {
  const double per_newton = pressed_.sum / normal_n_;
  PerBed<float> goal;
  for (std::size_t j = 0; j < kMost; ++j) goal[j] = static_cast<float>(carried_n_[j] * per_newton);
  kernels_->settle(loads_[0].data(), pressed_.rest.data(), pressed_.touching,
                   {goal.data(), static_cast<float>(kSettled) * pressed_.sum, static_cast<float>(far)},
                   which.data(), vectors_);
}

void WinklerFoundations::settle_taken_over() noexcept {
  if (std::ranges::none_of(taken_over_, [](std::int32_t which) { return which < 0; })) return;
  settle(taken_over_, 2 * square(std::cbrt(normal_n_)));
  taken_over_ = {};
  summed_ = false;
}

void WinklerFoundations::follow(double normal_n, double shear_n) noexcept {
  if (!(normal_n > 0)) return clear();
  if (normal_n == normal_n_ && shear_n == asked_n_) return settle_taken_over();
  const double d_normal = normal_n - normal_n_, radius = std::cbrt(normal_n),
               radius_before = std::cbrt(normal_n_);
  reach(radius);
  PerBed<float> slope{};
  PerBed<std::int32_t> slips = taken_over_;
  bool any_sticks = false, any_slips = false;
  for (std::size_t j = 0; j < count_; ++j) {
    const double target_n = std::clamp(shear_n * inverse_[j], -normal_n, normal_n);
    const double d_shear = target_n - carried_n_[j];
    const bool all_slips = std::fabs(target_n) >= normal_n;
    const bool sticks = slips[j] == 0 && !all_slips && d_normal > 0 && std::fabs(d_shear) <= d_normal;
    slope[j] = sticks ? static_cast<float>(d_shear / d_normal) : 0;
    slips[j] = sticks ? 0 : -1;
    any_sticks |= sticks;
    any_slips |= !sticks;
    carried_n_[j] = target_n;
  }
  const Pressed before = std::exchange(pressed_, pressed_by(radius));
  if (any_sticks) {  // the new ring takes its share
    Rest grown;
    for (std::size_t i = 0; i < kSprings; ++i) grown[i] = pressed_.rest[i] - before.rest[i];
    kernels_->stretch(loads_[0].data(), grown.data(), slope.data(), vectors_);
  }
  normal_n_ = normal_n;
  asked_n_ = shear_n;
  if (any_slips) settle(slips, square(radius) + square(radius_before));
  taken_over_ = {};
  copy_of_.fill(kNone);
  summed_ = false;
}

void WinklerFoundations::assume_monotonic(double normal_n, double shear_n) noexcept {
  clear();
  follow(normal_n, 0);
  follow(normal_n, shear_n);
}

void WinklerFoundations::take_over(std::size_t from, const PerBed<std::int32_t>& which) noexcept {
  if (!(normal_n_ > 0)) return;
  PerBed<float> ratio{};
  for (std::size_t j = 0; j < count_; ++j) {
    if (which[j] == 0) continue;
    ratio[j] = static_cast<float>(friction_[from] * inverse_[j]);
    carried_n_[j] = std::clamp(asked_n_ * inverse_[j], -normal_n_, normal_n_);
    taken_over_[j] = -1;
  }
  kernels_->take_over(loads_[0].data(), pressed_.rest.data(), from, ratio.data(), which.data(), vectors_);
}

// <u>_p = 2/5 sets the scale (u = r^2/a^2), so that what the springs are too coarse for cancels. A spring at
// x stands for 2 x^2 of <r^2> and 8/3 x^4 of <r^4>, over those of p.
void WinklerFoundations::sum_up() const noexcept {
  const float p = pressed_.sum;
  float p2 = 0;
  for (std::size_t i = 0; i < kSprings; ++i) p2 += pressed_.rest[i] * (place(i) * place(i));
  PerBed<float> q, q2, q4;
  kernels_->sums(loads_[0].data(), q.data(), q2.data(), q4.data(), vectors_);
  const double newton = normal_n_ / p;
#pragma omp simd
  for (std::size_t j = 0; j < count_; ++j) {
    const double u = 0.4 * q2[j] / p2, u2 = 8.0 / 3 * 0.04 * q4[j] * (p / p2) * (p / p2);
    moments_.slip_n[j] = newton * friction_[j] * (5.0 / 3 * q[j] - 2.5 * p * u);
    moments_.legendre_n[j] = newton * friction_[j] * (6 * u2 - 6 * p * u + q[j]);
  }
  summed_ = true;
}

contact::ShearMoments WinklerFoundations::shear_moments(std::size_t j) const noexcept {
  if (!(normal_n_ > 0)) return {};
  if (!summed_) sum_up();
  return {moments_.slip_n[j], moments_.legendre_n[j]};
}

}  // namespace slipd
