#include "drivers/sim/effects/rough_contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numeric/random.hpp"

namespace slipd::sim {
namespace {

enum ContactStream : std::uint64_t { height_stream, texture_stream };

// Bisections of an interval: to 1e-12 of it, below any noise.
constexpr int kHalvings = 40;
// An object that falls is caught by something sooner or later: no faster than this, m/s.
constexpr double kFastestSlideMPerS = 0.5;
// From one contact to the next, m: longer than any wave of the relief, and no multiple of one.
constexpr double kNextPlaceM = 0.3173;

// x in [low, high] with rising(x) = value.
template <class Function>
double solve(Function rising, double value, double low, double high) noexcept {
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    (rising(middle) < value ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

RoughContact::RoughContact(const RoughContactSettings& settings, std::span<const double> x_m,
                           std::span<const double> y_m, double area_m2, std::uint64_t seed)
    : settings_(settings),
      texture_(settings.texture, RandomStream(seed).stream(texture_stream).bits(0)),
      x_m_(x_m.begin(), x_m.end()),
      y_m_(y_m.begin(), y_m.end()),
      stiffness_n_m_(settings.modulus_pa * area_m2 / settings.thickness_m),
      gap_m_(x_m.size()),
      anchor_m_(x_m.size()),
      normal_n_(x_m.size()),
      shear_n_(x_m.size()),
      limit_n_(x_m.size()) {
  const RandomStream draws = RandomStream(seed).stream(height_stream);
  for (std::size_t i = 0; i < x_m_.size(); ++i) {
    double sum = 0;  // of three uniform numbers: standard deviation 1
    for (std::uint64_t k = 0; k < 3; ++k) sum += static_cast<double>(draws.noise(3 * i + k));
    height_m_.push_back(settings.height_sigma_m * sum);
    side_.push_back(y_m_[i] > 0 ? settings.one_side_friction : 1);
  }
  place_object();
}

void RoughContact::begin_anew() noexcept {
  if (pressed_n_ == 0) return;
  ++contacts_;
  std::fill(normal_n_.begin(), normal_n_.end(), 0);
  std::fill(shear_n_.begin(), shear_n_.end(), 0);
  std::fill(limit_n_.begin(), limit_n_.end(), 0);
  std::fill(anchor_m_.begin(), anchor_m_.end(), 0);
  pressed_n_ = capacity_n_ = carried_n_ = shift_m_ = slid_m_ = speed_m_s_ = 0;
  place_object();
}

// Gaps between the elements and the object where it lies now; the narrowest is 0.
void RoughContact::place_object() noexcept {
  const double from_m = kNextPlaceM * static_cast<double>(contacts_) - slid_m_;
  double narrowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < x_m_.size(); ++i) {
    const double dx = x_m_[i] - settings_.apex_x_m, dy = y_m_[i] - settings_.apex_y_m;
    gap_m_[i] = settings_.curvature_per_m * (dx * dx + dy * dy) / 2 - height_m_[i] -
                texture_.height_m(x_m_[i] + from_m, y_m_[i]);
    narrowest = std::min(narrowest, gap_m_[i]);
  }
  for (double& gap : gap_m_) gap -= narrowest;
}

double RoughContact::force_at(double approach_m) const noexcept {
  double sum = 0;
  for (const double gap : gap_m_) sum += std::max(0.0, approach_m - gap);
  return stiffness_n_m_ * sum;
}

void RoughContact::press(double normal_n, double friction) noexcept {
  if (!(normal_n > 0)) return begin_anew();
  // One element alone would go this far; none of them can go farther.
  const double approach_m =
      solve([this](double at_m) { return force_at(at_m); }, normal_n, 0, normal_n / stiffness_n_m_);
  pressed_n_ = normal_n;
  capacity_n_ = 0;
  for (std::size_t i = 0; i < gap_m_.size(); ++i) {
    const bool touched = normal_n_[i] > 0;
    normal_n_[i] = stiffness_n_m_ * std::max(0.0, approach_m - gap_m_[i]);
    if (!touched) anchor_m_[i] = shift_m_;
    limit_n_[i] = friction * side_[i] * normal_n_[i];
    capacity_n_ += limit_n_[i];
  }
}

double RoughContact::element_shear(std::size_t i, double shift_m) const noexcept {
  return std::clamp(settings_.tangential * stiffness_n_m_ * (shift_m - anchor_m_[i]), -limit_n_[i],
                    limit_n_[i]);
}

double RoughContact::shear_at(double shift_m) const noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < anchor_m_.size(); ++i) sum += element_shear(i, shift_m);
  return sum;
}

void RoughContact::pull(double shear_n, double dt_s) noexcept {
  if (!(pressed_n_ > 0)) return;
  if (speed_m_s_ == 0 && std::fabs(shear_n) < capacity_n_) {
    stick(shear_n);
  } else {
    slide(shear_n, dt_s);
  }
}

void RoughContact::stick(double shear_n) noexcept {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  const double stiffness = settings_.tangential * stiffness_n_m_;
  for (std::size_t i = 0; i < anchor_m_.size(); ++i) {
    low = std::min(low, anchor_m_[i] - limit_n_[i] / stiffness);
    high = std::max(high, anchor_m_[i] + limit_n_[i] / stiffness);
  }
  shift_m_ = solve([this](double at_m) { return shear_at(at_m); }, shear_n, low, high);
  carried_n_ = 0;
  for (std::size_t i = 0; i < anchor_m_.size(); ++i) {
    shear_n_[i] = element_shear(i, shift_m_);
    anchor_m_[i] = shift_m_ - shear_n_[i] / stiffness;
    carried_n_ += shear_n_[i];
  }
}

void RoughContact::slide(double shear_n, double dt_s) noexcept {
  const double way = speed_m_s_ != 0 ? std::copysign(1, speed_m_s_) : std::copysign(1, shear_n);
  const double speed_m_s = speed_m_s_ + (shear_n - way * capacity_n_) / settings_.mass_kg * dt_s;
  speed_m_s_ = way * std::clamp(way * speed_m_s, 0.0, kFastestSlideMPerS);
  slid_m_ += speed_m_s_ * dt_s;
  for (std::size_t i = 0; i < anchor_m_.size(); ++i) {
    shear_n_[i] = way * limit_n_[i];
    anchor_m_[i] = shift_m_ - shear_n_[i] / (settings_.tangential * stiffness_n_m_);
  }
  carried_n_ = way * capacity_n_;
  place_object();
}

double RoughContact::safety_margin() const noexcept {
  if (!(pressed_n_ > 0)) return std::numeric_limits<double>::quiet_NaN();
  return sliding() ? 0 : std::max(0.0, 1 - std::fabs(carried_n_) / capacity_n_);
}

double RoughContact::friction() const noexcept {
  return pressed_n_ > 0 ? capacity_n_ / pressed_n_ : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace slipd::sim
