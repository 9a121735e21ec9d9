#include "core/reading/fit/fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/frame/significance.hpp"
#include "core/numeric/bounded_step.hpp"
#include "core/patch/rings.hpp"
#include "core/reading/method/method.hpp"
#include "core/reading/method/profile_posterior.hpp"
#include "core/reading/moments/moments.hpp"

namespace slipd {
namespace {

constexpr std::size_t kRings = 12;
// Hertz: p0 = 3 P/(2 pi a^2).
double peak_pressure(const ContactPatch& patch) noexcept {
  return 1.5 * patch.normal_n / (std::numbers::pi * patch.radius_m * patch.radius_m);
}

}  // namespace

Fit::Fit(const TaxelLayout& layout, Range friction_expected, const FitOptions& options, std::size_t most)
    : layout_(layout),
      options_(options),
      prior_{.expected = friction_expected, .spread = options.prior.scene_spread} {
  for (auto* list : {&x_, &y_, &p_, &q_, &u_, &v_}) list->resize(most);
  for (auto* sheet : {&outer_, &inner_}) {
    for (auto* list : {&sheet->value, &sheet->d_x, &sheet->d_u, &sheet->d_v}) list->resize(most);
  }
  slopes_.resize(2 * static_cast<Eigen::Index>(most), kUnknowns);
  residuals_.resize(2 * static_cast<Eigen::Index>(most));
}

std::size_t Fit::list_bytes() const noexcept {
  // Lists, two residuals and their slopes a sample, and the dome sheet's.
  constexpr std::size_t kNumbersASample = 2 + 6 + 8 + 2 * (kUnknowns + 1) + 7;
  return kNumbersASample * sizeof(double) * x_.size();
}

// Lengths in units of the first radius and pressures in units of p0 keep the normal equations well scaled.
void Fit::set_noise(const ContactPatch& patch, double taxels_along) noexcept {
  const double floor_pa = options_.noise_floor * peak_pressure(patch);
  frame_.noise_normal_pa = std::max(patch.noise_normal_pa, floor_pa) / taxels_along;
  frame_.noise_shear_pa =
      std::max(patch.noise_shear_pa, floor_pa * patch.shear_n / patch.normal_n) / taxels_along;
}

Fit::Vector Fit::start(const ContactPatch& patch, const MomentRatio& ratio) const noexcept {
  const double a = patch.radius_m;
  Vector at;
  at[center_x] = at[center_y] = 0;
  at[radius] = a;
  at[height] = 1.5 * patch.normal_n / (std::numbers::pi * a * a * a);
  at[load] = ratio.load;
  at[margin] = std::clamp(gamma_of_moment_ratio(ratio.value), options_.min_start, options_.max_start);
  return at;
}

double Fit::evaluate(const Vector& at, Vector& gradient, Square& hessian) noexcept {
  const double gamma = at[margin], k = std::cbrt(gamma), rest = 1 - gamma, b = at[height], t = at[load];
  const double a = at[radius];
  for (std::size_t i = 0; i < frame_.count; ++i) {
    u_[i] = x_[i] - at[center_x];
    v_[i] = y_[i] - at[center_y];
  }
  fill_sheet(a, at, outer_);
  fill_sheet(k * a, at, inner_);

  using Values = Eigen::Map<const Eigen::ArrayXd>;
  const auto n = static_cast<Eigen::Index>(frame_.count);
  const auto values = [n](const std::vector<double>& list) { return Values(list.data(), n); };
  const double wp = 1 / frame_.noise_normal_pa, wq = 1 / frame_.noise_shear_pa, shape = b * t / rest;
  const double dk = a / (3 * k * k);  // of k a by Gamma
  const Values outer = values(outer_.value), inner = values(inner_.value), inner_x = values(inner_.d_x);

  auto jp = slopes_.topRows(n).array();
  jp.col(center_x) = -wp * b * values(outer_.d_u);
  jp.col(center_y) = -wp * b * values(outer_.d_v);
  jp.col(radius) = wp * b * values(outer_.d_x);
  jp.col(height) = wp * outer;
  jp.rightCols(2).setZero();
  residuals_.head(n) = wp * (b * outer - values(p_));

  auto jq = slopes_.middleRows(n, n).array();
  jq.col(center_x) = -wq * shape * (values(outer_.d_u) - values(inner_.d_u));
  jq.col(center_y) = -wq * shape * (values(outer_.d_v) - values(inner_.d_v));
  jq.col(radius) = wq * shape * (values(outer_.d_x) - k * inner_x);
  jq.col(height) = wq * shape / b * (outer - inner);
  jq.col(load) = wq * b / rest * (outer - inner);
  jq.col(margin) = wq * shape * ((outer - inner) / rest - dk * inner_x);
  residuals_.segment(n, n) = wq * (shape * (outer - inner) - values(q_));

  // Column by column, as plain products of vectors: Eigen's matrix products may take memory for their blocks.
  const auto columns = slopes_.topRows(2 * n);
  const auto left = residuals_.head(2 * n);
  for (int row = 0; row < kUnknowns; ++row) {
    gradient[row] = columns.col(row).dot(left);
    for (int column = 0; column <= row; ++column) {
      hessian(row, column) = hessian(column, row) = columns.col(row).dot(columns.col(column));
    }
  }
  return 0.5 * left.squaredNorm();
}

// Residuals summed ring by ring: noise averages out in a ring, another history does not.
Fit::RingMisfit Fit::ring_misfit(const Vector& at) const noexcept {
  const double shape = at[height] * at[load] / (1 - at[margin]);
  struct Ring {
    double off = 0, held = 0, taxels = 0;
  };
  std::array<Ring, kRings> rings;
  for (std::size_t i = 0; i < frame_.count; ++i) {
    const double s = std::hypot(u_[i], v_[i]) / at[radius];
    auto& ring = rings[std::min(static_cast<std::size_t>(s * kRings), kRings - 1)];
    ring.off += shape * (outer_.value[i] - inner_.value[i]) - q_[i];
    ring.held += shape * outer_.value[i];
    ring.taxels += 1;
  }
  RingMisfit sums;
  int used = 0;
  for (const auto& ring : rings) {
    if (ring.taxels < 1) continue;
    const double uneven = options_.uneven_share * ring.held,
                 noise = frame_.noise_shear_pa * frame_.noise_shear_pa * ring.taxels;
    sums.by_noise += ring.off * ring.off / noise;
    sums.by_skin += ring.off * ring.off / (noise + uneven * uneven);
    ++used;
  }
  return used > 0 ? RingMisfit{sums.by_noise / used, sums.by_skin / used} : sums;
}

// Residual pressure that no noise explains, part by part of the disc, as a share of its peak: a contact that
// is tilted, elliptic or sensed through a skin is off to one side or another, an array with dead taxels here
// and there. Shear is off by as much, and its residual does not show that, as the margin gives way to it.
double Fit::residual_pressure(const Vector& at) const noexcept {
  constexpr double kFitted = 4;  // unknowns of the pressure: place, radius, height
  struct Part {
    double off = 0, taxels = 0;
  };
  std::array<Part, 16> parts;
  const double half = 0.5 * at[radius] * at[radius];
  for (std::size_t i = 0; i < frame_.count; ++i) {
    const double u = u_[i], v = v_[i];
    const std::size_t which = (u > 0 ? 1U : 0U) + (v > 0 ? 2U : 0U) +
                              (std::fabs(u) > std::fabs(v) ? 4U : 0U) + (u * u + v * v > half ? 8U : 0U);
    parts[which].off += p_[i] - at[height] * outer_.value[i];
    parts[which].taxels += 1;
  }
  double sum = 0;
  for (const Part& part : parts) sum += part.taxels > 0 ? part.off * part.off / part.taxels : 0;
  const double free = static_cast<double>(parts.size()) - kFitted;
  const double by_noise = frame_.noise_normal_pa * frame_.noise_normal_pa;
  if (sum < (free + options_.clear_sigmas * std::sqrt(2 * free)) * by_noise) return 0;
  return std::sqrt((sum - free * by_noise) / static_cast<double>(frame_.count)) / (at[height] * at[radius]);
}

// The profile holds place, size and height of the contact as they fit best, and they are not known so well:
// the margin's variance with them held, over that with them free.
double Fit::profile_share(const Square& hessian) const noexcept {
  const Square covariance = hessian.inverse();
  const double free = covariance(margin, margin);
  const double held =
      1 / (hessian(margin, margin) - hessian(load, margin) * hessian(load, margin) / hessian(load, load));
  const double share = held / free;
  return share > 0 && share < 1 ? std::max(share, options_.min_profile_share) : 1;
}

// Where noise leaves the margin open, the likelihood is no parabola about the best fit. The whole range is
// weighed instead: the likelihood of each margin, times the prior of the friction that it would need.
void Fit::weigh_by_prior(const Vector& at, const Square& hessian, Reading& out) noexcept {
  const double share = profile_share(hessian);
  ProfileFriction friction;
  auto& profile = out.profile;
  const auto n = static_cast<Eigen::Index>(frame_.count);
  const Eigen::Map<const Eigen::ArrayXd> q(q_.data(), n), outer(outer_.value.data(), n);
  Eigen::Map<Eigen::ArrayXd> ring(inner_.value.data(), n);
  for (std::size_t j = 0; j < MarginProfile::kSteps; ++j) {
    const double gamma = MarginProfile::gamma_of(j);
    fill_sheet(std::cbrt(gamma) * at[radius], at, inner_);
    ring = (outer - ring) * (at[height] / (1 - gamma));
    const double square = ring.square().sum(), product = (ring * q).sum();
    const double t = std::max(options_.min_traction_ratio, product / square);
    friction[j] = t / (1 - gamma);
    profile.misfit[j] =
        share * 0.5 * (t * t * square - 2 * t * product) / (frame_.noise_shear_pa * frame_.noise_shear_pa);
  }
  weigh_profile(friction, prior_, out);
}

Fit::Minimum Fit::minimise(const Vector& start, double converged_sigmas) noexcept {
  Minimum best{start, {}, false};
  Vector gradient, trial_gradient;
  Square trial_hessian;
  double cost = evaluate(best.at, gradient, best.hessian), damping = options_.first_damping;
  for (frame_.steps = 0; frame_.steps < kMostSteps && !best.converged; ++frame_.steps) {
    const double gamma = best.at[margin];
    Vector trial = best.at + bounded_step(best.hessian, gradient, damping, margin, options_.min_gamma - gamma,
                                          options_.max_gamma - gamma);
    // Once more, as rounding may pass the bound.
    trial[margin] = std::clamp(trial[margin], options_.min_gamma, options_.max_gamma);
    trial[radius] = std::clamp(trial[radius], best.at[radius] / options_.max_radius_factor,
                               best.at[radius] * options_.max_radius_factor);
    if (!trial.allFinite()) break;
    const double trial_cost = evaluate(trial, trial_gradient, trial_hessian);
    if (trial_cost <= cost) {
      const Vector moved = trial - best.at;
      const double moved_sigmas = (moved.array().abs() * best.hessian.diagonal().array().sqrt()).maxCoeff();
      best.at = trial;
      cost = trial_cost;
      gradient = trial_gradient;
      best.hessian = trial_hessian;
      damping = std::max(options_.min_damping, damping / options_.damping_factor);
      best.converged = moved_sigmas < converged_sigmas;
    } else {
      damping *= options_.damping_factor;
      best.converged = damping > options_.max_damping;
    }
  }
  return best;
}

bool Fit::take_last_step(Minimum& minimum) noexcept {
  Vector gradient;
  evaluate(minimum.at, gradient, minimum.hessian);
  const Vector step = -minimum.hessian.ldlt().solve(gradient);
  const double squares = -step.dot(gradient);  // of its length in standard deviations
  Vector at = minimum.at + step;
  at[margin] = std::clamp(at[margin], options_.min_gamma, options_.max_gamma);
  const double most = kStandsOutSigmas;
  if (!at.allFinite() || !(squares < most * most) || !(at[radius] > 0)) return false;
  const auto move = [&](Sheet& sheet, double by_radius) {
#pragma omp simd
    for (std::size_t i = 0; i < frame_.count; ++i) {
      sheet.value[i] +=
          by_radius * sheet.d_x[i] - step[center_x] * sheet.d_u[i] - step[center_y] * sheet.d_v[i];
    }
  };
  move(outer_, step[radius]);
  move(inner_, std::cbrt(at[margin]) * at[radius] - std::cbrt(minimum.at[margin]) * minimum.at[radius]);
  for (std::size_t i = 0; i < frame_.count; ++i) {
    u_[i] -= step[center_x];
    v_[i] -= step[center_y];
  }
  minimum.at = at;
  ++frame_.steps;
  return true;
}

bool Fit::describe(const ContactPatch& patch, const Minimum& minimum, Reading& out) const noexcept {
  const Vector& at = minimum.at;
  const Square covariance = minimum.hessian.inverse();
  const double variance = covariance(margin, margin);
  if (!(variance > 0) || !std::isfinite(variance)) return false;
  const double load_sigmas = at[load] / std::sqrt(covariance(load, load));
  if (!(load_sigmas > kClearSigmas)) return false;
  out.gamma = at[margin];
  out.sigma = load_sigmas > options_.faint_load_sigmas ? std::sqrt(variance) : 1;
  const double utilisation = 1 - out.gamma;
  out.friction = at[load] / utilisation;
  out.friction_sigma =
      out.sigma < kKnownFrictionShare * utilisation
          ? out.friction * std::hypot(out.sigma / utilisation, std::sqrt(covariance(load, load)) / at[load])
          : std::numeric_limits<double>::infinity();
  place(patch, at, out);
  return true;
}

void Fit::place(const ContactPatch& patch, const Vector& at, Reading& out) noexcept {
  out.center_x_m = patch.center_x_m + at[center_x];
  out.center_y_m = patch.center_y_m + at[center_y];
  out.radius_m = at[radius];
}

Reading Fit::estimate(const Frame& /*frame*/, const ContactPatch& patch) noexcept {
  frame_ = {};
  collect(patch);
  const MomentRatio ratio = moment_ratio(patch, layout_, options_.ratio);
  Reading out;
  out.moments = ratio.moments;
  out.moments_sigma = ratio.moments_sigma;
  out.moments_common_sigma = ratio.moments_common_sigma;
  read(patch, ratio, out);
  return out;
}

std::optional<Fit::Vector> Fit::start_of(const ContactPatch& patch, const MomentRatio& ratio) const noexcept {
  const Vector first = start(patch, ratio);
  if (!(first[load] > 0) || frame_.count < kUnknowns) return std::nullopt;
  return first;
}

void Fit::conclude(const ContactPatch& patch, const MomentRatio& ratio, const Minimum& minimum,
                   Reading& out) noexcept {
  const Vector& at = minimum.at;
  if (!minimum.converged || !describe(patch, minimum, out)) return;
  const HertzDeviationOptions& deviation = options_.ratio.deviation;
  const RingMisfit misfit = ring_misfit(at);
  out.in_model = ratio.deviation.hertzian(deviation) && misfit.by_skin < kMaxRingMisfit;
  if (out.sigma > options_.open_sigma) weigh_by_prior(at, minimum.hessian, out);
  // A residual beyond noise is taken for an uneven skin; it may as well be a little of another history.
  const double uneven = misfit.by_noise > kMaxRingMisfit ? options_.uneven_sigma : 0;
  const double unlike =
      std::max(options_.pressure_sigma * residual_pressure(at), ratio.deviation.sigma(deviation));
  const double model_sigma = std::hypot(uneven, unlike);
  out.sigma = std::hypot(out.sigma, model_sigma);
  out.common_sigma = model_sigma;
  out.friction_sigma =
      std::hypot(out.friction_sigma, options_.friction_sigma_factor * model_sigma * out.friction);
}

}  // namespace slipd
