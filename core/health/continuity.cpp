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

}  // namespace

// A contact whose force changes in one frame changes its size by Hertz's theory: the radius goes with the
// cube root of the force. The less of it, the less both overlap.
double Continuity::by_growth(const ContactPatch& patch) const noexcept {
  const double moved_m = norm(patch.center_x_m - last_center_x_m_, patch.center_y_m - last_center_y_m_);
  const double overlap = std::max(0.0, 1 - moved_m / std::min(patch.radius_m, last_radius_m_));
  const double less_n = std::min(patch.normal_n, last_normal_n_);
  const double more_n = std::max(patch.normal_n, last_normal_n_);
  return overlap * unlikeness_of_sizes(std::cbrt(less_n / more_n));
}

bool Continuity::unlike(const ContactPatch& patch, const PatternChange& pattern, std::size_t probes,
                        bool fast, const ContinuityOptions& options) noexcept {
  const double unlikeness = pattern.unlikeness();
  if (!std::isfinite(unlikeness)) return false;
  const double noise_pa2 =
      std::max(patch.noise_normal_pa * patch.noise_normal_pa, last_noise_pa_ * last_noise_pa_) *
      static_cast<double>(probes);
  const double by_noise = noise_pa2 / pattern.square_pa2 + noise_pa2 / pattern.square_before_pa2;
  const double least = fast ? options.least_unlike_fast : options.least_unlike + by_growth(patch);
  const bool jumped = unlikeness_.known() && unlikeness > least &&
                      unlikeness > kBeyondUsual * std::max(unlikeness_.peak, by_noise);
  if (!jumped) unlikeness_.learn(unlikeness);
  return jumped;
}

bool Continuity::turned(const ContactPatch& patch, const ContinuityOptions& options) noexcept {
  const double x_n = patch.shear_x_n, y_n = patch.shear_y_n;
  const double turn_rad = std::fabs(std::atan2(last_shear_x_n_ * y_n - last_shear_y_n_ * x_n,
                                               last_shear_x_n_ * x_n + last_shear_y_n_ * y_n));
  const double step_n = norm(x_n - last_shear_x_n_, y_n - last_shear_y_n_);
  const double by_noise =
      patch.shear_sigma_n / patch.shear_n + last_shear_sigma_n_ / norm(last_shear_x_n_, last_shear_y_n_);
  const bool jumped = turn_.known() && turn_rad > kTurned &&
                      step_n > options.least_turn_share * patch.normal_n &&
                      turn_rad > kBeyondUsual * std::max(turn_.peak, by_noise);
  if (!jumped) turn_.learn(turn_rad);
  return jumped;
}

// All pressures grew or fell by a factor, and the contact's size did not. It lasts until the force is of the
// former size again.
bool Continuity::scaled(const ContactPatch& patch, const PatternChange& pattern,
                        const ContinuityOptions& options) noexcept {
  const double most = std::log(kWrongScale);
  if (scaled_from_n_ > 0) {
    if (log_ratio(patch.normal_n, scaled_from_n_) > most / 2) return true;
    scaled_from_n_ = 0;
  } else if (log_ratio(patch.normal_n, last_normal_n_) > most &&
             pattern.unlikeness() < options.least_unlike_fast) {
    scaled_from_n_ = last_normal_n_;
    return true;
  }
  return false;
}

void Continuity::skip(std::int64_t time_ns) noexcept {
  last_ns_ = time_ns;
  last_clear_ = last_directed_ = false;
}

Health Continuity::update(std::int64_t time_ns, const ContactPatch& patch, const PatternChange& pattern,
                          std::size_t probes, const ContinuityOptions& options) noexcept {
  const bool clear = patch.in_contact && patch.normal_n > kStrongSigmas * patch.normal_sigma_n;
  const bool directed = clear && patch.shear_n > 0 && patch.shear_n > kStandsOutSigmas * patch.shear_sigma_n;
  const double step_s = kSecondsPerNano * static_cast<double>(time_ns - last_ns_);
  // What a contact did while frames were lost is no jump.
  const bool regular = last_ns_ != 0 && (usual_step_s_ <= 0 || step_s <= kBeyondUsual * usual_step_s_);
  if (last_ns_ != 0 && step_s > 0)
    usual_step_s_ += (usual_step_s_ > 0 ? 1.0 / kMemoryFrames : 1) * (step_s - usual_step_s_);
  last_ns_ = time_ns;
  Health health = Health::good;
  if (!patch.in_contact) {
    scaled_from_n_ = 0;
    unlikeness_ = turn_ = {};
  } else if (regular && clear && last_clear_) {
    const bool fast = step_s <= options.fast_step_s;
    const bool turn = fast && directed && last_directed_ && turned(patch, options);
    if (unlike(patch, pattern, probes, fast, options) || turn) broken_at_n_ = patch.normal_n;
    if (scaled(patch, pattern, options)) health = Health::wrong_scale;
  }
  if (!clear || kWrongScale * patch.normal_n < broken_at_n_) broken_at_n_ = 0;
  if (broken_at_n_ > 0 && health == Health::good) health = Health::jump;
  last_clear_ = clear;
  last_directed_ = directed;
  last_normal_n_ = patch.normal_n;
  last_noise_pa_ = patch.noise_normal_pa;
  last_center_x_m_ = patch.center_x_m;
  last_center_y_m_ = patch.center_y_m;
  last_radius_m_ = patch.radius_m;
  last_shear_x_n_ = patch.shear_x_n;
  last_shear_y_n_ = patch.shear_y_n;
  last_shear_sigma_n_ = patch.shear_sigma_n;
  return health;
}

}  // namespace slipd
