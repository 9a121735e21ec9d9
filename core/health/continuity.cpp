#include "core/health/continuity.hpp"

#include <algorithm>
#include <cmath>

#include "core/frame/significance.hpp"
#include "core/load/load_path.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

constexpr double kSecondsPerNano = 1e-9;

double log_ratio(double a, double b) noexcept {
  return a > 0 && b > 0 ? std::fabs(std::log(a / b)) : 0;
}

// 1 - cos^2 between the pressures of two Hertz contacts with one centre, of which one has `ratio` times the
// other's radius; ratio 0 … 1. cos = 2 ratio * integral of sqrt((1 - t)(1 - ratio^2 t)) for t of 0 … 1.
double unlikeness_of_sizes(double ratio) noexcept {
  constexpr double kAlike = 0.999;  // the closed form loses its digits beyond, and the result is below 1e-6
  if (ratio >= kAlike) return 0;
  if (ratio <= 0) return 1;
  const double square = ratio * ratio;
  const double cosine = 2 * ratio *
                        ((1 + square) / (4 * square) - (1 - square) * (1 - square) / (8 * square * ratio) *
                                                           std::log((1 + ratio) / (1 - ratio)));
  return std::clamp(1 - cosine * cosine, 0.0, 1.0);
}

// A contact whose force changes in one frame changes its size by Hertz's theory: the radius goes with the
// cube root of the force. The less of it, the less both overlap.
double by_growth(const ContactNumbers& now, const ContactNumbers& before) noexcept {
  const double moved_m = norm(now.center_x_m - before.center_x_m, now.center_y_m - before.center_y_m);
  const double overlap = std::max(0.0, 1 - moved_m / std::min(now.radius_m, before.radius_m));
  const double less_n = std::min(now.normal_n, before.normal_n);
  const double more_n = std::max(now.normal_n, before.normal_n);
  return overlap * unlikeness_of_sizes(std::cbrt(less_n / more_n));
}

}  // namespace

bool SeenFrame::clear() const noexcept {
  return contact.in_contact && contact.normal_n > kStrongSigmas * contact.normal_sigma_n;
}

bool SeenFrame::directed() const noexcept {
  return clear() && contact.shear_n > 0 && contact.shear_n > kStandsOutSigmas * contact.shear_sigma_n;
}

bool Continuity::unlike(const Step& step) noexcept {
  const ContactNumbers &now = step.now.contact, &before = step.before.contact;
  const double unlikeness = step.pattern.unlikeness();
  if (!std::isfinite(unlikeness)) return false;
  const double noise_pa = std::max(now.noise_normal_pa, before.noise_normal_pa);
  const double noise_pa2 = noise_pa * noise_pa * static_cast<double>(step.probes);
  const double by_noise = noise_pa2 / step.pattern.square_pa2 + noise_pa2 / step.pattern.square_before_pa2;
  const double least =
      step.fast ? options_.least_unlike_fast : options_.least_unlike + by_growth(now, before);
  const bool jumped = unlikeness_.known() && unlikeness > least &&
                      unlikeness > kBeyondUsual * std::max(unlikeness_.peak, by_noise);
  if (!jumped) unlikeness_.learn(unlikeness);
  return jumped;
}

bool Continuity::turned(const Step& step) noexcept {
  const ContactNumbers &now = step.now.contact, &before = step.before.contact;
  const double turn_rad =
      std::fabs(std::atan2(before.shear_x_n * now.shear_y_n - before.shear_y_n * now.shear_x_n,
                           before.shear_x_n * now.shear_x_n + before.shear_y_n * now.shear_y_n));
  const double step_n = norm(now.shear_x_n - before.shear_x_n, now.shear_y_n - before.shear_y_n);
  const double by_noise = norm(now.shear_sigma_n / now.shear_n, before.shear_sigma_n / before.shear_n);
  const bool jumped = turn_.known() && turn_rad > kTurned &&
                      step_n > options_.least_turn_share * now.normal_n &&
                      turn_rad > std::max(kBeyondUsual * turn_.peak, kStandsOutSigmas * by_noise);
  if (!jumped) turn_.learn(turn_rad);
  return jumped;
}

// All pressures grew or fell by a factor, and the contact's size did not. It lasts until the force is of the
// former size again.
bool Continuity::scaled(const Step& step) noexcept {
  const double most = std::log(kWrongScale);
  const double now_n = step.now.contact.normal_n, before_n = step.before.contact.normal_n;
  if (scaled_from_n_ > 0) {
    if (log_ratio(now_n, scaled_from_n_) > most / 2) return true;
    scaled_from_n_ = 0;
  } else if (log_ratio(now_n, before_n) > most && step.pattern.unlikeness() < options_.least_unlike_fast) {
    scaled_from_n_ = before_n;
    return true;
  }
  return false;
}

Health Continuity::update(const SeenFrame& now, const std::optional<SeenFrame>& before,
                          const PatternChange& pattern, std::size_t probes) noexcept {
  const bool follows = before && !skipped_;
  skipped_ = false;
  const double step_s = before ? kSecondsPerNano * static_cast<double>(now.time_ns - before->time_ns) : 0;
  // What a contact did while frames were lost is no jump.
  const bool regular = usual_step_s_ <= 0 || step_s <= kBeyondUsual * usual_step_s_;
  if (step_s > 0) usual_step_s_ += (usual_step_s_ > 0 ? 1.0 / kMemoryFrames : 1) * (step_s - usual_step_s_);
  Health health = Health::good;
  const double normal_n = now.contact.normal_n;
  if (!now.contact.in_contact) {
    scaled_from_n_ = 0;
    unlikeness_ = turn_ = {};
  } else if (follows && regular && now.clear() && before->clear()) {
    const Step step{now, *before, pattern, probes, step_s <= options_.fast_step_s};
    const bool turn = step.fast && now.directed() && before->directed() && turned(step);
    if (unlike(step) || turn) broken_at_n_ = normal_n;
    if (scaled(step)) health = Health::wrong_scale;
  }
  if (!now.clear() || kWrongScale * normal_n < broken_at_n_) broken_at_n_ = 0;
  if (broken_at_n_ > 0 && health == Health::good) health = Health::jump;
  return health;
}

}  // namespace slipd
