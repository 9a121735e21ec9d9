#include "core/friction/pillar_beds.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

// Newton's steps for a shift; its start is the frame before, so that few are needed.
constexpr int kMostSteps = 8;
// What a pillar that slips still counts for in the slope, so that there is one when all slip.
constexpr double kSlipping = 0.03;
// A shift has settled within this share of P, below what noise makes of it.
constexpr double kSettled = 1e-3;

double square(double x) noexcept {
  return x * x;
}

// The symmetric matrix of a shift's slope.
struct Slope {
  double xx = 0, yy = 0, tt = 0, xt = 0, yt = 0;

  void add(double weight, double x, double y) noexcept {
    xx += weight;
    yy += weight;
    xt -= weight * y;
    yt += weight * x;
    tt += weight * (x * x + y * y);
  }
  // A step that takes off `rest`. Pillars in one row do not turn.
  std::array<double, 3> solve(const std::array<double, 3>& rest) const noexcept {
    const double turn = tt - xt * xt / xx - yt * yt / yy;
    const double t = turn > 1e-9 * tt ? (rest[2] - xt * rest[0] / xx - yt * rest[1] / yy) / turn : 0;
    return {(rest[0] - xt * t) / xx, (rest[1] - yt * t) / yy, t};
  }
};

}  // namespace

PillarBeds::PillarBeds(const TaxelLayout& layout, std::span<const double> frictions,
                       const PillarBedsOptions& options)
    : options_(options), taxels_(layout.size()), count_(frictions.size()), area_m2_(layout.area_m2()) {
  if (taxels_ < kLeastPillars || taxels_ > kMostPillars || count_ > kMost)
    throw std::invalid_argument("skin.base pillars needs 4 to 64 taxels");
  std::ranges::copy(frictions, friction_.begin());
  double x = 0, y = 0, squares = 0;
  for (std::size_t i = 0; i < taxels_; ++i) {
    x += layout.x_m()[i] / static_cast<double>(taxels_);
    y += layout.y_m()[i] / static_cast<double>(taxels_);
  }
  for (std::size_t i = 0; i < taxels_; ++i) {
    place_[i] = {layout.x_m()[i] - x, layout.y_m()[i] - y};
    squares += square(place_[i].x) + square(place_[i].y);
  }
  const double size_m = std::sqrt(squares / static_cast<double>(taxels_));
  for (Vector& place : place_) place = {place.x / size_m, place.y / size_m};
}

void PillarBeds::clear() noexcept {
  seen_ = true;
  touching_ = 0;
  for (std::size_t j = 0; j < count_; ++j) loads_[j] = {};
}

void PillarBeds::follow(const ContactPatch& patch, double seconds) noexcept {
  sense(patch);
  const double drawn = -std::expm1(-seconds / options_.memory_s);
  for (std::size_t j = 0; j < count_; ++j) {
    if (!seen_) loads_[j] = sheared_;
    settle(j);
    misfit_[j] = misfit_of(j);
    draw_to_sensed(j, drawn);
  }
  seen_ = true;
}

void PillarBeds::sense(const ContactPatch& patch) noexcept {
  const TaxelView& taxels = patch.taxels;
  noise_n_ = area_m2_ * patch.noise_shear_pa;
  const double least_n = kClearSigmas * area_m2_ * patch.noise_normal_pa;
  touching_ = 0;
  sensed_n_ = 0;
  goal_ = {};
  for (std::size_t i = 0; i < taxels_; ++i) {
    pressed_[i] = area_m2_ * taxels.normal_pa[i];
    sheared_[i] = {area_m2_ * taxels.shear_x_pa[i], area_m2_ * taxels.shear_y_pa[i]};
    touches_[i] = pressed_[i] > least_n;
    if (!touches_[i]) continue;
    ++touching_;
    sensed_n_ += pressed_[i];
    goal_[0] += sheared_[i].x;
    goal_[1] += sheared_[i].y;
    goal_[2] += place_[i].x * sheared_[i].y - place_[i].y * sheared_[i].x;
  }
  carried_n_ = norm(goal_[0], goal_[1]);
}

// What a pillar that holds `limit` >= 0 carries of a load.
PillarBeds::Vector PillarBeds::held(const Vector& load, double limit) noexcept {
  const double squared = square(load.x) + square(load.y);
  if (!(squared > square(limit))) return load;
  const double part = limit / std::sqrt(squared);
  return {part * load.x, part * load.y};
}

PillarBeds::Vector PillarBeds::moved(std::size_t j, std::size_t i, const Shift& shift) const noexcept {
  const Vector load = loads_[j][i];
  return {load.x + shift[0] - shift[2] * place_[i].y, load.y + shift[1] + shift[2] * place_[i].x};
}

// Shifts and turns all pillars of bed j, each as far as its friction lets it, until together they carry what
// is sensed.
void PillarBeds::settle(std::size_t j) noexcept {
  if (carried_n_ >= friction_[j] * sensed_n_) return slide(j);
  const double settled_n = kSettled * sensed_n_;
  const double most_n = touching_ > 0 ? friction_[j] * sensed_n_ / static_cast<double>(touching_) : 0;
  Shift shift{};
  for (int step = 0; step < kMostSteps; ++step) {
    Sums rest = goal_;
    Slope slope;
    for (std::size_t i = 0; i < taxels_; ++i) {
      if (!touches_[i]) continue;
      const Vector asked = moved(j, i, shift), v = held(asked, friction_[j] * pressed_[i]);
      const bool slips = v.x != asked.x || v.y != asked.y;
      rest[0] -= v.x;
      rest[1] -= v.y;
      rest[2] -= place_[i].x * v.y - place_[i].y * v.x;
      slope.add(slips ? kSlipping : 1, place_[i].x, place_[i].y);
    }
    if (touching_ == 0 || std::max({std::fabs(rest[0]), std::fabs(rest[1]), std::fabs(rest[2])}) < settled_n)
      break;
    const Shift more = slope.solve(rest);
    for (std::size_t k = 0; k < shift.size(); ++k) shift[k] += std::clamp(more[k], -most_n, most_n);
  }
  for (std::size_t i = 0; i < taxels_; ++i)
    loads_[j][i] = touches_[i] ? held(moved(j, i, shift), friction_[j] * pressed_[i]) : Vector{};
}

// More than friction holds is sensed: all pillars slip along the pull.
void PillarBeds::slide(std::size_t j) noexcept {
  const double per_n = carried_n_ > 0 ? friction_[j] / carried_n_ : 0;
  for (std::size_t i = 0; i < taxels_; ++i) {
    const double part = touches_[i] ? per_n * pressed_[i] : 0;
    loads_[j][i] = {part * goal_[0], part * goal_[1]};
  }
}

void PillarBeds::draw_to_sensed(std::size_t j, double share) noexcept {
  for (std::size_t i = 0; i < taxels_; ++i) {
    if (!touches_[i]) continue;
    Vector& load = loads_[j][i];
    load = held({load.x + share * (sheared_[i].x - load.x), load.y + share * (sheared_[i].y - load.y)},
                friction_[j] * pressed_[i]);
  }
}

double PillarBeds::misfit_of(std::size_t j) const noexcept {
  if (touching_ == 0) return 0;
  const auto pillars = static_cast<double>(touching_);
  const double floor = square(noise_n_) + square(options_.uneven_share * carried_n_ / pillars) +
                       square(kModelSigma * sensed_n_ / pillars);
  double sum = 0;
  for (std::size_t i = 0; i < taxels_; ++i) {
    if (!touches_[i]) continue;
    const Vector& load = loads_[j][i];
    const double off = square(sheared_[i].x - load.x) + square(sheared_[i].y - load.y);
    sum += off / (floor + square(options_.uneven_share) * (square(load.x) + square(load.y)));
  }
  return sum;
}

}  // namespace slipd
