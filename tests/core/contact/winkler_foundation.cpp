#include "tests/core/contact/winkler_foundation.hpp"

#include <algorithm>
#include <cmath>

#include "core/contact/hertz.hpp"

namespace slipd::contact {
namespace {

constexpr int kMostSteps = 12;

constexpr float place(std::size_t i) noexcept {
  return static_cast<float>(i) + 0.5F;
}

}  // namespace

void WinklerFoundation::clear() noexcept {
  step_ = normal_n_ = shear_n_ = 0;
  load_.fill(0);
}

// Places the springs wider when the contact has become wider than their row.
void WinklerFoundation::reach(double radius) noexcept {
  if (radius <= step_ * kSprings) return;
  const double step = kSpare * radius / kSprings, ratio = step_ > 0 ? step / step_ : 0;
  Row old = load_;
  load_.fill(0);
  for (std::size_t i = 0; i < kSprings && ratio > 0; ++i) {
    const double at = ratio * (static_cast<double>(i) + 0.5) - 0.5;
    if (at >= kSprings - 1) break;
    const auto low = static_cast<std::size_t>(std::max(0.0, at));
    const double part = std::max(0.0, at - static_cast<double>(low));
    load_[i] = static_cast<float>((1 - part) * old[low] + part * old[low + 1]);
  }
  step_ = step;
}

void WinklerFoundation::limits(double edge, double friction, Row& most) const noexcept {
  const auto square = static_cast<float>(step_ * step_), outside = static_cast<float>(edge),
             mu = static_cast<float>(friction);
  for (std::size_t i = 0; i < kSprings; ++i) {
    const float rest = outside - square * place(i) * place(i);
    most[i] = rest > 0 ? mu * rest : 0;
  }
}

// The sum of edge - x^2 over the springs in contact: the normal force in the springs' unit.
double WinklerFoundation::touching(double edge) const noexcept {
  Row rest;
  limits(edge, 1, rest);
  float sum = 0;
  for (const float r : rest) sum += r;
  return sum;
}

// Shifts all springs together, each as far as its friction limit allows, until they carry `target`.
void WinklerFoundation::settle(const Row& most, double target) noexcept {
  float low = 0, high = 0, shift = 0;
  for (std::size_t i = 0; i < kSprings; ++i) {
    low = std::min(low, -most[i] - load_[i]);
    high = std::max(high, most[i] - load_[i]);
  }
  const auto goal = static_cast<float>(target);
  float all = 0;
  for (const float m : most) all += m;
  const float open = 1e-5F * all;  // of the most that they can carry
  for (int n = 0; n < kMostSteps; ++n) {
    float sum = 0, sticking = 0;
    for (std::size_t i = 0; i < kSprings; ++i) {
      const float t = load_[i] + shift;
      sum += std::min(std::max(t, -most[i]), most[i]);
      sticking += std::fabs(t) < most[i] ? 1.0F : 0.0F;
    }
    const float off = sum - goal;
    if (std::fabs(off) < open) break;
    (off < 0 ? low : high) = shift;
    const float newton = sticking > 0 ? shift - off / sticking : low - 1;
    shift = newton > low && newton < high ? newton : 0.5F * (low + high);
  }
  for (std::size_t i = 0; i < kSprings; ++i) {
    load_[i] = std::min(std::max(load_[i] + shift, -most[i]), most[i]);
  }
}

void WinklerFoundation::follow(double normal_n, double shear_n, double friction) noexcept {
  if (!(normal_n > 0)) {
    clear();
    return;
  }
  const double radius = std::cbrt(normal_n), edge = radius * radius;
  reach(radius);
  const double most_n = friction * normal_n, target_n = std::clamp(shear_n, -most_n, most_n);
  const double d_normal = normal_n - normal_n_, d_shear = target_n - shear_n_;
  Row most;
  limits(edge, friction, most);
  if (std::fabs(target_n) < most_n && d_normal > 0 &&
      std::fabs(d_shear) <= friction * d_normal) {  // all springs stick; the new ring takes its share
    const double old_radius = std::cbrt(normal_n_), old_edge = old_radius * old_radius;
    const auto slope = static_cast<float>(d_shear / d_normal);
    Row before;
    limits(edge, 1, most);
    limits(old_edge, 1, before);
    for (std::size_t i = 0; i < kSprings; ++i) load_[i] += slope * (most[i] - before[i]);
  } else {
    settle(most, target_n / normal_n * touching(edge));
  }
  normal_n_ = normal_n;
  shear_n_ = target_n;
}

void WinklerFoundation::assume_monotonic(double normal_n, double shear_n, double friction) noexcept {
  clear();
  follow(normal_n, 0, friction);
  follow(normal_n, shear_n, friction);
}

void WinklerFoundation::fall_to(double friction) noexcept {
  const double radius = std::cbrt(normal_n_);
  Row most;
  limits(radius * radius, friction, most);
  for (std::size_t i = 0; i < kSprings; ++i) load_[i] = std::min(std::max(load_[i], -most[i]), most[i]);
}

ShearMoments WinklerFoundation::shear_moments() const noexcept {
  if (!(normal_n_ > 0)) return {};
  const double radius = std::cbrt(normal_n_);
  Row rest;
  limits(radius * radius, 1, rest);
  float p = 0, p2 = 0, q = 0, q2 = 0, q4 = 0;
  for (std::size_t i = 0; i < kSprings; ++i) {
    const float square = place(i) * place(i);
    p += rest[i];
    p2 += rest[i] * square;
    q += load_[i];
    q2 += load_[i] * square;
    q4 += load_[i] * square * square;
  }
  // Scaled so that <u>_p = 2/5: this cancels the error of a row of few springs.
  const double newton = normal_n_ / p, u = 0.4 * q2 / p2, u2 = 8.0 / 3 * 0.04 * q4 * (p / p2) * (p / p2);
  return {newton * (5.0 / 3 * q - 2.5 * p * u), newton * (6 * u2 - 6 * p * u + q)};
}

}  // namespace slipd::contact
