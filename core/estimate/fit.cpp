#include "core/estimate/fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/estimate/moments.hpp"

namespace slipd {
namespace {

constexpr double kLeastGamma = 1e-6, kMostGamma = 1 - 1e-4;
constexpr double kUneven = 0.02;       // of mu p: what a real skin may deviate, ring by ring
constexpr double kUnevenSigma = 0.03;  // of a margin read off a skin as uneven as that
constexpr double kMostMisfit = 4;      // mean square over rings, about 1 in the family
constexpr double kConverged = 1e-3;    // of each unknown's own standard deviation
constexpr std::size_t kRings = 12;
constexpr double kClearly = 4;          // deviations
constexpr double kPressureSigma = 0.9;  // of Gamma, over what is left of the pressure
constexpr double kOpen = 0.04;          // a sigma of Gamma beyond which the scene is asked
constexpr std::size_t kSteps = MarginProfile::kSteps;
constexpr double kLeastOpen = 0.1;
constexpr double kSceneSpread = 0.15;  // how softly the scene's range of friction ends, in log mu

}  // namespace

Fit::Fit(const TaxelLayout& layout, Range friction_expected)
    : layout_(layout), expected_(friction_expected), sheet_(layout.size(), layout.side_m()) {
  for (auto* list : {&x_, &y_, &p_, &q_, &u_, &v_}) list->resize(layout.size());
  for (auto* sheet : {&outer_, &inner_}) {
    for (auto* list : {&sheet->value, &sheet->d_x, &sheet->d_u, &sheet->d_v}) list->resize(layout.size());
  }
  slopes_.resize(2 * static_cast<Eigen::Index>(layout.size()), kUnknowns);
  residuals_.resize(2 * static_cast<Eigen::Index>(layout.size()));
}

// Lengths in units of the first radius and pressures in units of p0 keep the normal equations well scaled.
void Fit::collect(const ContactPatch& patch) noexcept {
  count_ = 0;
  const auto take = [&](std::uint32_t i) {
    x_[count_] = layout_.x_m()[i] - patch.center_x_m;
    y_[count_] = layout_.y_m()[i] - patch.center_y_m;
    p_[count_] = patch.taxels.normal_pa[i];
    q_[count_] = patch.shear_along_pa(i);
    ++count_;
  };
  if (layout_.size() <= kFewTaxels) {  // where so little is felt, what is not felt tells as well
    for (std::uint32_t i = 0; i < layout_.size(); ++i) take(i);
  } else {
    patch.for_each_inside(take);
  }
}

Fit::Vector Fit::start(const ContactPatch& patch, const MomentRatio& ratio) const noexcept {
  const double a = patch.radius_m;
  Vector at;
  at[center_x] = at[center_y] = 0;
  at[radius] = a;
  at[height] = 1.5 * patch.normal_n / (3.141592653589793 * a * a * a);
  at[load] = ratio.load;
  at[margin] = std::clamp(gamma_of_moment_ratio(ratio.value), 0.05, 0.95);
  return at;
}

double Fit::evaluate(const Vector& at, Vector& gradient, Square& hessian) noexcept {
  const double gamma = at[margin], k = std::cbrt(gamma), rest = 1 - gamma, b = at[height], t = at[load];
  const double a = at[radius];
  const std::span<double> u(u_.data(), count_), v(v_.data(), count_);
  for (std::size_t i = 0; i < count_; ++i) {
    u[i] = x_[i] - at[center_x];
    v[i] = y_[i] - at[center_y];
  }
  const auto sheet = [&](double x, Sheet& out) {
    sheet_.evaluate(x, u, v, {out.value.data(), count_}, {out.d_x.data(), count_}, {out.d_u.data(), count_},
                    {out.d_v.data(), count_});
  };
  sheet(a, outer_);
  sheet(k * a, inner_);

  using Values = Eigen::Map<const Eigen::ArrayXd>;
  const auto n = static_cast<Eigen::Index>(count_);
  const auto values = [n](const std::vector<double>& list) { return Values(list.data(), n); };
  const double wp = 1 / noise_normal_, wq = 1 / noise_shear_, shape = b * t / rest;
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

// What is left over, ring by ring: noise averages out in a ring, another history does not.
Fit::RingMisfit Fit::ring_misfit(const Vector& at) const noexcept {
  const double shape = at[height] * at[load] / (1 - at[margin]);
  struct Ring {
    double off = 0, held = 0, taxels = 0;
  };
  std::array<Ring, kRings> rings;
  for (std::size_t i = 0; i < count_; ++i) {
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
    const double uneven = kUneven * ring.held, noise = noise_shear_ * noise_shear_ * ring.taxels;
    sums.by_noise += ring.off * ring.off / noise;
    sums.by_skin += ring.off * ring.off / (noise + uneven * uneven);
    ++used;
  }
  return used > 0 ? RingMisfit{sums.by_noise / used, sums.by_skin / used} : sums;
}

// What no noise explains of the pressure, part by part of the disc, as a share of its peak: a contact that is
// tilted, elliptic or felt through a skin is off to one side or another, an array with dead taxels here and
// there. Shear is off by as much, and that is not seen in what is left of it, as the margin gives way to it.
double Fit::pressure_left_over(const Vector& at) const noexcept {
  struct Part {
    double off = 0, taxels = 0;
  };
  std::array<Part, 16> parts;
  const double half = 0.5 * at[radius] * at[radius];
  for (std::size_t i = 0; i < count_; ++i) {
    const double u = u_[i], v = v_[i];
    const std::size_t which = (u > 0 ? 1U : 0U) + (v > 0 ? 2U : 0U) +
                              (std::fabs(u) > std::fabs(v) ? 4U : 0U) + (u * u + v * v > half ? 8U : 0U);
    parts[which].off += p_[i] - at[height] * outer_.value[i];
    parts[which].taxels += 1;
  }
  double sum = 0;
  for (const Part& part : parts) sum += part.taxels > 0 ? part.off * part.off / part.taxels : 0;
  const double free = parts.size() - 4.0, by_noise = noise_normal_ * noise_normal_;  // the fit took four
  if (sum < (free + kClearly * std::sqrt(2 * free)) * by_noise) return 0;
  return std::sqrt((sum - free * by_noise) / static_cast<double>(count_)) / (at[height] * at[radius]);
}

// The profile below holds place, size and height of the contact as they fit best. They are not known so well:
// the margin's variance with them held, over that with them free.
double Fit::share_left_open(const Square& hessian) noexcept {
  const Square covariance = hessian.inverse();
  const double free = covariance(margin, margin);
  const double held =
      1 / (hessian(margin, margin) - hessian(load, margin) * hessian(load, margin) / hessian(load, load));
  const double share = held / free;
  return share > 0 && share < 1 ? std::max(share, kLeastOpen) : 1;
}

// Where noise leaves the margin open, a parabola about the best fit is no honest picture of it
// (docs/theory.md §10.4). The whole range is weighed instead: the likelihood of each margin, times what
// friction the scene expects of it. Mean and deviation of that.
void Fit::weigh_by_scene(const Vector& at, const Square& hessian, FrameEstimate& out) noexcept {
  const double open = share_left_open(hessian);
  std::array<double, kSteps> misfit, friction;
  auto& profile = out.profile;
  double least = std::numeric_limits<double>::infinity(), least_expected = least;
  const auto n = static_cast<Eigen::Index>(count_);
  const Eigen::Map<const Eigen::ArrayXd> q(q_.data(), n), outer(outer_.value.data(), n);
  Eigen::Map<Eigen::ArrayXd> ring(inner_.value.data(), n);
  for (std::size_t j = 0; j < kSteps; ++j) {
    const double gamma = (static_cast<double>(j) + 0.5) / kSteps;
    sheet_.evaluate(std::cbrt(gamma) * at[radius], {u_.data(), count_}, {v_.data(), count_},
                    {inner_.value.data(), count_}, {inner_.d_x.data(), count_}, {inner_.d_u.data(), count_},
                    {inner_.d_v.data(), count_});
    ring = (outer - ring) * (at[height] / (1 - gamma));
    const double square = ring.square().sum(), product = (ring * q).sum();
    const double t = std::max(1e-6, product / square);
    friction[j] = t / (1 - gamma);
    const double unexpected =
        std::max({0.0, std::log(friction[j] / expected_.high), std::log(expected_.low / friction[j])});
    profile.misfit[j] = open * 0.5 * (t * t * square - 2 * t * product) / (noise_shear_ * noise_shear_);
    misfit[j] = profile.misfit[j] + 0.5 * unexpected * unexpected / (kSceneSpread * kSceneSpread);
    least = std::min(least, profile.misfit[j]);
    least_expected = std::min(least_expected, misfit[j]);
  }
  for (double& value : profile.misfit) value -= least;
  profile.known = true;
  double weight = 0, mean = 0, square = 0, mu = 0, mu2 = 0;
  for (std::size_t j = 0; j < kSteps; ++j) {
    const double w = std::exp(least_expected - misfit[j]), gamma = (static_cast<double>(j) + 0.5) / kSteps;
    weight += w;
    mean += w * gamma;
    square += w * gamma * gamma;
    mu += w * friction[j];
    mu2 += w * friction[j] * friction[j];
  }
  mean /= weight;
  mu /= weight;
  out.gamma = mean;
  out.sigma = std::sqrt(std::max(0.0, square / weight - mean * mean) + 1.0 / (12 * kSteps * kSteps));
  out.friction = mu;
  const double step =
      mu / std::max(1 - mean, 0.5 / kSteps) / kSteps;  // what one step of Gamma means for friction
  out.friction_sigma = std::sqrt(std::max(0.0, mu2 / weight - mu * mu) + step * step / 12);
}

FrameEstimate Fit::estimate(const Frame&, const ContactPatch& patch) noexcept {
  FrameEstimate out;
  collect(patch);
  const double peak = 1.5 * patch.normal_n / (3.141592653589793 * patch.radius_m * patch.radius_m);
  noise_normal_ = std::max(patch.noise_normal_pa, 1e-4 * peak);
  noise_shear_ = std::max(patch.noise_shear_pa, 1e-4 * peak * patch.shear_n / patch.normal_n);
  const MomentRatio ratio = moment_ratio(patch, layout_);
  out.moments = ratio.moments;
  out.moments_sigma = ratio.moments_sigma;
  Vector at = start(patch, ratio), gradient, trial_gradient;
  if (!(at[load] > 0) || count_ < kUnknowns) return out;
  Square hessian, trial_hessian;
  double cost = evaluate(at, gradient, hessian), damping = 1e-3;
  bool converged = false;
  for (steps_ = 0; steps_ < kMostSteps && !converged; ++steps_) {
    Square damped = hessian;
    damped.diagonal() *= 1 + damping;
    const Vector step = -damped.ldlt().solve(gradient);
    Vector trial = at + step;
    trial[margin] = std::clamp(trial[margin], kLeastGamma, kMostGamma);
    trial[radius] = std::clamp(trial[radius], 0.5 * at[radius], 2 * at[radius]);
    if (!trial.allFinite()) break;
    const double trial_cost = evaluate(trial, trial_gradient, trial_hessian);
    if (trial_cost <= cost) {
      const Vector moved = trial - at;
      const double small = (moved.array().abs() * hessian.diagonal().array().sqrt()).maxCoeff();
      at = trial;
      cost = trial_cost;
      gradient = trial_gradient;
      hessian = trial_hessian;
      damping = std::max(1e-9, damping / 10);
      converged = small < kConverged;
    } else {
      damping *= 10;
      converged = damping > 1e6;
    }
  }
  if (layout_.size() <= kFewTaxels) {  // no parabola is true to so few: only the whole profile means anything
    evaluate(at, trial_gradient, trial_hessian);
    weigh_by_scene(at, trial_hessian, out);
    out.in_model = converged;
    return out;
  }
  if (!converged) return out;
  const Square covariance = hessian.inverse();
  const double variance = covariance(margin, margin);
  if (!(variance > 0) || !std::isfinite(variance)) return out;
  out.gamma = at[margin];
  out.sigma = std::sqrt(variance);
  const double rest = 1 - out.gamma;
  out.friction = at[load] / rest;
  out.friction_sigma =
      out.sigma < 0.5 * rest
          ? out.friction * std::hypot(out.sigma / rest, std::sqrt(covariance(load, load)) / at[load])
          : std::numeric_limits<double>::infinity();
  out.center_x_m = patch.center_x_m + at[center_x];
  out.center_y_m = patch.center_y_m + at[center_y];
  out.radius_m = at[radius];
  const RingMisfit misfit = ring_misfit(at);
  out.in_model = ratio.deviation.hertzian() && misfit.by_skin < kMostMisfit;
  if (out.sigma > kOpen) weigh_by_scene(at, hessian, out);
  // Beyond noise it is accepted as an uneven skin; it may as well be a little of another history.
  const double uneven = misfit.by_noise > kMostMisfit ? kUnevenSigma : 0;
  const double deviation = std::max(kPressureSigma * pressure_left_over(at), ratio.deviation.sigma());
  const double doubt = std::hypot(uneven, deviation);
  out.sigma = std::hypot(out.sigma, doubt);
  out.friction_sigma = std::hypot(out.friction_sigma, 2 * doubt * out.friction);
  return out;
}

}  // namespace slipd
