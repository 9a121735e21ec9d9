#include "core/advice/alert.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

// The share of a Gaussian that is more than so many standard deviations above its middle.
double share_beyond(double sigmas) noexcept {
  return 0.5 * std::erfc(sigmas / std::numbers::sqrt2);
}

}  // namespace

double cost_of(double sigmas) noexcept {
  return share_beyond(-sigmas) / share_beyond(sigmas);
}

// The share falls from 1 to 0, so that halves of an interval that has the answer close in on it.
double sigmas_for(double cost) noexcept {
  const double share = 1 / (1 + cost);
  double low = -30, high = 30;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (share_beyond(middle) > share ? low : high) = middle;
  }
  return (low + high) / 2;
}

void AlertLogic::Stopwatch::pause(std::int64_t for_ns) noexcept {
  if (since_ns_ >= 0) since_ns_ += for_ns;
}

bool AlertLogic::Stopwatch::has_run(bool condition, std::int64_t now_ns, std::int64_t least_ns) noexcept {
  if (!condition) {
    restart();
    return false;
  }
  if (since_ns_ < 0) since_ns_ = now_ns;
  return now_ns - since_ns_ >= least_ns;
}

Alert AlertLogic::update(std::int64_t time_ns, const Estimate& now, bool watched) noexcept {
  const std::int64_t passed_ns = time_ns - std::exchange(last_ns_, time_ns);
  std::optional<double> margin = now.gamma_low;
  if (settings_.use == AlertUse::margin) {
    margin = now.gamma;
    if (margin) *margin -= sigmas_ * now.sigma.value_or(0);
  }
  if (now.state == State::no_contact) {
    below_warn_.restart();
    below_slip_.restart();
    above_.restart();
    level_ = Alert::none;
  } else if (margin) {
    still_ns_ = 0;
    level_ = level_after(time_ns, *margin);
  } else {
    watch_unsupported(passed_ns, now);
    below_warn_.pause(passed_ns);
    below_slip_.pause(passed_ns);
    above_.restart();
  }
  if (watched || margin || now.state == State::no_contact) watched_ns_ = time_ns;
  const bool none_holds = watched_ns_ && time_ns - *watched_ns_ <= kNoneHoldsNs;
  return level_ != Alert::none || none_holds ? level_ : Alert::unknown;
}

// A sample without a margin. Time in which no sample came shows nothing.
void AlertLogic::watch_unsupported(std::int64_t passed_ns, const Estimate& now) noexcept {
  if (slides(now.sliding)) still_ns_ = 0;
  if (now.sliding == Sliding::none) still_ns_ += std::min(passed_ns, kNoneHoldsNs);
  if (still_ns_ >= kStillNs) level_ = Alert::none;
}

// The level after a sample whose margin is known.
Alert AlertLogic::level_after(std::int64_t time_ns, double margin) noexcept {
  const auto least_ns = static_cast<std::int64_t>(settings_.min_ms * 1e6);
  const bool slip = below_slip_.has_run(margin < settings_.slip_below, time_ns, least_ns);
  const bool warn = below_warn_.has_run(margin < settings_.warn_below, time_ns, least_ns);
  if (slip) {
    level_ = Alert::slip;
  } else if (warn && level_ == Alert::none) {
    level_ = Alert::warn;
  }
  if (level_ == Alert::none) return level_;
  const double leave =
      (level_ == Alert::slip ? settings_.slip_below : settings_.warn_below) + settings_.hysteresis;
  if (above_.has_run(margin >= leave, time_ns, least_ns)) {
    level_ = margin >= settings_.warn_below + settings_.hysteresis ? Alert::none : Alert::warn;
    above_.restart();
  }
  return level_;
}

void AlertLogic::judge(Estimate& out) noexcept {
  const bool sliding = slides(out.sliding);
  out.alert = update(out.time_ns, out, out.sliding.has_value());
  out.alert_cause = is_raised(out.alert) ? AlertCause::margin : AlertCause::none;
  if (sliding && out.alert != Alert::slip) {
    out.alert = Alert::slip;
    out.alert_cause = AlertCause::sliding;
  }
}

std::optional<double> SlipForecast::update(std::int64_t time_ns, std::optional<double> gamma,
                                           double sigma) noexcept {
  if (!gamma) {
    weight_ = 0;
    return std::nullopt;
  }
  const double passed = static_cast<double>(time_ns - last_ns_) * 1e-9;
  last_ns_ = time_ns;
  if (weight_ == 0 || passed <= 0) {
    weight_ = 1;
    t_ = tt_ = tg_ = 0;
    g_ = *gamma;
    gg_ = *gamma * *gamma;
    return std::nullopt;
  }
  // Sums about the present: what was at t is at t - passed now.
  const double keep = std::exp(-passed / options_.forget_s);
  tt_ = keep * (tt_ - 2 * passed * t_ + passed * passed * weight_);
  tg_ = keep * (tg_ - passed * g_);
  t_ = keep * (t_ - passed * weight_);
  weight_ = keep * weight_ + 1;
  g_ = keep * g_ + *gamma;
  gg_ = keep * gg_ + *gamma * *gamma;
  const double spread = tt_ - t_ * t_ / weight_, free = weight_ - 2;  // a line has two unknowns
  if (free <= 0 || spread <= 0) return std::nullopt;
  const double slope = (tg_ - t_ * g_ / weight_) / spread;
  const double scatter = std::max(0.0, gg_ - g_ * g_ / weight_ - slope * slope * spread) / free;
  const double least = std::max(sigma, kExactShare);
  const double slope_sigma =
      std::sqrt(std::max(scatter, options_.independent_share * least * least) / spread);
  if (!(slope < -kClearSigmas * slope_sigma)) return std::nullopt;
  return std::max(0.0, *gamma / -slope);
}

GripAdvice grip_advice(double normal_n, double shear_n, double shear_sigma_n, std::optional<double> friction,
                       std::optional<double> friction_sigma, double target_margin) noexcept {
  if (!friction || !(*friction > 0) || !(target_margin < 1)) return {};
  const double per_shear = 1 / (*friction * (1 - target_margin));
  const double of_friction = shear_n * per_shear * friction_sigma.value_or(0) / *friction;
  return {std::max(0.0, shear_n * per_shear - normal_n), norm(of_friction, shear_sigma_n * per_shear)};
}

void advise(Estimate& out, double pull_sigma_n, double target_margin) noexcept {
  if (!out.normal_n || !out.shear_n) return;
  const GripAdvice advice = grip_advice(*out.normal_n, out.pull_n.value_or(*out.shear_n), pull_sigma_n,
                                        out.friction, out.friction_sigma, target_margin);
  out.grip_increase_n = advice.increase_n;
  out.grip_increase_sigma_n = advice.sigma_n;
}

}  // namespace slipd
