#include "core/estimate/imprint_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "core/estimate/imprint_slopes.hpp"
#include "core/estimate/profile_posterior.hpp"

namespace slipd {
namespace {

using contact::FeltTensor;
using Sheet = contact::SubsurfaceSheet;

// An ellipse's axes are apart by at least this, log of their ratio: else its angle means nothing.
constexpr double kLeastLogAxes = 1e-3;

}  // namespace

ImprintFit::ImprintFit(const TaxelLayout& layout, Range friction_expected, double depth_m,
                       const FitOptions& fit, const ImprintFitOptions& options)
    : layout_(layout),
      fit_(fit),
      options_(options),
      prior_{.expected = friction_expected, .spread = fit.prior.scene_spread},
      depth_m_(depth_m),
      outer_(layout.size(), layout.side_m(), depth_m),
      inner_(layout.size(), layout.side_m(), depth_m) {
  for (auto* list : {&x_, &y_, &u_, &v_}) list->resize(layout.size());
  const auto rows = 3 * static_cast<Eigen::Index>(layout.size());
  data_.resize(rows);
  residuals_.resize(rows);
  slopes_.resize(rows, kMost);
  choose_imprint_loops();
}

std::size_t ImprintFit::memory_bytes() const noexcept {
  const std::size_t components = depth_m_ > 0 ? std::size_t{Sheet::kComponents} : 1;
  // Places; data, residual and slopes of three channels; both sheets' rows.
  constexpr std::size_t kPlaces = 4, kOfChannels = 3 * (std::size_t{2} + kMost),
                        kRows = 2 * std::size_t{Sheet::kRows};
  return sizeof(*this) + layout_.size() * sizeof(double) * (kPlaces + kOfChannels + kRows * components);
}

// In a frame with x along the resultant. Under a skin, what lies around the disc is felt as well.
void ImprintFit::collect(const ContactPatch& patch) noexcept {
  count_ = 0;
  const double c = patch.direction_x, s = patch.direction_y;
  const auto take = [&](std::uint32_t i) {
    const double x = layout_.x_m()[i] - patch.center_x_m, y = layout_.y_m()[i] - patch.center_y_m;
    x_[count_] = c * x + s * y;
    y_[count_] = c * y - s * x;
    u_[count_] = i;
    ++count_;
  };
  if (!(depth_m_ > 0)) {
    patch.for_each_inside(take);
  } else {
    const double reach = 1.06 * patch.radius_m + 0.71 * layout_.side_m() + options_.reach_depths * depth_m_;
    const bool all = layout_.size() <= kFewTaxels;
    for (std::uint32_t i = 0; i < layout_.size(); ++i) {
      const double x = layout_.x_m()[i] - patch.center_x_m, y = layout_.y_m()[i] - patch.center_y_m;
      if (all || x * x + y * y < reach * reach) take(i);
    }
  }
  const auto n = static_cast<Eigen::Index>(count_);
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto i = static_cast<std::uint32_t>(u_[static_cast<std::size_t>(j)]);
    const double qx = patch.taxels.shear_x_pa[i], qy = patch.taxels.shear_y_pa[i];
    data_[j] = patch.taxels.normal_pa[i];
    data_[n + j] = c * qx + s * qy;
    data_[2 * n + j] = c * qy - s * qx;
  }
}

// The felt pressure is wider than the one that acts, and its centre is drawn along the pull, by d Q/P.
ImprintFit::Full ImprintFit::start(const ContactPatch& patch, const MomentRatio& ratio) const noexcept {
  constexpr double kLeastShare = 0.4;  // of the felt radius
  const double felt = patch.radius_m;
  const double a = std::sqrt(std::max(felt * felt - options_.start_spread * depth_m_ * depth_m_,
                                      kLeastShare * kLeastShare * felt * felt));
  Full at = Full::Zero();
  at[load] = ratio.load;
  at[center_x] = -depth_m_ * ratio.load;
  at[size] = a;
  at[peak] = 1.5 * patch.normal_n / (std::numbers::pi * a * a);
  at[margin] = depth_m_ > 0 ? options_.start_gamma
                            : std::clamp(gamma_of_moment_ratio(ratio.value), fit_.min_start, fit_.max_start);
  return at;
}

contact::Ellipse ImprintFit::ellipse_of(const Full& at, double scale) noexcept {
  const double apart = std::hypot(at[along], at[across]), stretch = std::exp(0.5 * apart);
  return {scale * at[size] * stretch, scale * at[size] / stretch, 0.5 * std::atan2(at[across], at[along])};
}

void ImprintFit::place(const Full& at) noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    u_[i] = x_[i] - at[center_x];
    v_[i] = y_[i] - at[center_y];
  }
}

double ImprintFit::evaluate(const Full& from, int unknowns, Vector& gradient, Square& hessian) noexcept {
  Full at = from;
  if (unknowns == kRound) {
    at[along] = at[across] = 0;
  } else if (std::hypot(at[along], at[across]) < kLeastLogAxes) {
    at[along] = kLeastLogAxes;
    at[across] = 0;
  }
  place(at);
  const double k = std::cbrt(at[margin]), rest = 1 - at[margin], apart = std::hypot(at[along], at[across]);
  const contact::Ellipse wide = ellipse_of(at, 1), narrow = ellipse_of(at, k);
  outer_.evaluate(wide, {u_.data(), count_}, {v_.data(), count_});
  inner_.evaluate(narrow, {u_.data(), count_}, {v_.data(), count_});
  const double per_apart = apart > 0 ? 1 / apart : 0;
  ImprintSlopes by{.outer = ImprintRows(outer_),
                   .inner = ImprintRows(inner_),
                   .wide = wide,
                   .narrow = narrow,
                   .peak = at[peak],
                   .shear = at[peak] * at[load] / rest,
                   .k = k,
                   .rest = rest,
                   .dk = 1 / (3 * k * k),
                   .c = std::cos(at[direction]),
                   .s = std::sin(at[direction]),
                   .c2 = at[along] * per_apart,
                   .s2 = at[across] * per_apart,
                   .turn = 0.5 * per_apart,
                   .per_size = 1 / at[size],
                   .per_normal = 1 / noise_normal_,
                   .per_shear = 1 / noise_shear_,
                   .surface = !(depth_m_ > 0),
                   .data = data_.data(),
                   .residuals = residuals_.data(),
                   .column = {},
                   .count = count_};
  for (int j = 0; j < unknowns; ++j) by.column[static_cast<std::size_t>(j)] = slopes_.col(j).data();
  std::array<double, kMost*(kMost + 1) / 2 + kMost> products;
  linearise_imprint(by, unknowns, products.data());
  gradient.resize(unknowns);
  hessian.resize(unknowns, unknowns);
  const double* next = products.data();
  for (int row = 0; row < unknowns; ++row) {
    for (int col = 0; col <= row; ++col) hessian(row, col) = hessian(col, row) = *next++;
  }
  for (int row = 0; row < unknowns; ++row) gradient[row] = *next++;
  return 0.5 * residuals_.head(3 * static_cast<Eigen::Index>(count_)).squaredNorm();
}

void ImprintFit::minimise(int unknowns, Minimum& best) noexcept {
  constexpr double kMostFall = 3;  // of the peak pressure in one step: it stays above 0
  Vector trial_gradient;
  Square trial_hessian;
  double damping = fit_.first_damping;
  best.converged = false;
  best.cost = evaluate(best.at, unknowns, best.gradient, best.hessian);
  for (int step_number = 0; step_number < kMostSteps && !best.converged; ++step_number, ++steps_) {
    Square damped = best.hessian;
    damped.diagonal() *= 1 + damping;
    const Vector step = -damped.ldlt().solve(best.gradient);
    Full trial = best.at;
    trial.head(unknowns) += step;
    trial[margin] = std::clamp(trial[margin], fit_.min_gamma, fit_.max_gamma);
    trial[size] = std::clamp(trial[size], best.at[size] / fit_.max_radius_factor,
                             best.at[size] * fit_.max_radius_factor);
    const double apart = std::hypot(trial[along], trial[across]);
    if (apart > options_.max_log_axes) {
      trial[along] *= options_.max_log_axes / apart;
      trial[across] *= options_.max_log_axes / apart;
    }
    if (!trial.allFinite()) break;
    trial[peak] = std::max(trial[peak], best.at[peak] / kMostFall);
    const double trial_cost = evaluate(trial, unknowns, trial_gradient, trial_hessian);
    if (trial_cost <= best.cost) {
      const auto moved = (trial - best.at).head(unknowns).array().abs();
      const double moved_sigmas = (moved * best.hessian.diagonal().array().sqrt()).maxCoeff();
      best.converged = best.cost - trial_cost < options_.settled_nats;
      best.at = trial;
      best.cost = trial_cost;
      best.gradient = trial_gradient;
      best.hessian = trial_hessian;
      damping = std::max(fit_.min_damping, damping / fit_.damping_factor);
      best.converged = best.converged || moved_sigmas < fit_.converged_sigmas;
    } else {
      damping *= fit_.damping_factor;
      best.converged = damping > fit_.max_damping || -0.5 * step.dot(best.gradient) < options_.settled_nats;
    }
  }
}

// Root mean squares of what is left over, each channel with its share of the unknowns.
void ImprintFit::measure_noise(const Minimum& best, int unknowns) noexcept {
  const auto n = static_cast<Eigen::Index>(count_);
  const double used = 1 - unknowns / (3.0 * static_cast<double>(n));
  const double floor_pa = fit_.noise_floor * best.at[peak];
  noise_normal_ = std::max(floor_pa, noise_normal_ * std::sqrt(residuals_.head(n).squaredNorm() /
                                                               (used * static_cast<double>(n))));
  noise_shear_ = std::max(floor_pa, noise_shear_ * std::sqrt(residuals_.segment(n, 2 * n).squaredNorm() /
                                                             (used * 2 * static_cast<double>(n))));
}

// By one step of Newton's method from the best round contact.
bool ImprintFit::shows_ellipse(const Minimum& round) noexcept {
  Vector gradient;
  Square hessian;
  evaluate(round.at, kMost, gradient, hessian);
  const Vector step = -hessian.ldlt().solve(gradient);
  const Square covariance = hessian.ldlt().solve(Square::Identity(kMost, kMost));
  const Eigen::Matrix2d spread = covariance.bottomRightCorner<2, 2>();
  const Eigen::Vector2d axes = step.tail<2>();
  const double squares = axes.dot(spread.ldlt().solve(axes));
  return squares > options_.elliptic_sigmas * options_.elliptic_sigmas;
}

// As Fit::residual_pressure, about the ellipse: part by part, where it lies clearly above noise.
double ImprintFit::residual_pressure(const Full& at) const noexcept {
  struct Part {
    double off = 0, taxels = 0;
  };
  std::array<Part, 16> parts;
  const double half = 0.5 * at[size] * at[size];
  for (std::size_t i = 0; i < count_; ++i) {
    const double u = u_[i], v = v_[i];
    Part& part = parts[(u > 0 ? 1U : 0U) + (v > 0 ? 2U : 0U) + (std::fabs(u) > std::fabs(v) ? 4U : 0U) +
                       (u * u + v * v > half ? 8U : 0U)];
    part.off += noise_normal_ * residuals_[static_cast<Eigen::Index>(i)];
    part.taxels += 1;
  }
  double squares = 0;
  for (const Part& part : parts) squares += part.taxels > 0 ? part.off * part.off / part.taxels : 0;
  const double fitted = elliptic_ ? 6 : 4, free = static_cast<double>(parts.size()) - fitted;
  const double by_noise = noise_normal_ * noise_normal_;
  if (squares < (free + fit_.clear_sigmas * std::sqrt(2 * free)) * by_noise) return 0;
  return std::sqrt((squares - free * by_noise) / static_cast<double>(count_)) / at[peak];
}

// As Fit::ring_misfit: noise averages out in a ring, another history of the load does not.
double ImprintFit::ring_misfit(const Full& at) const noexcept {
  constexpr std::size_t kRings = 12;
  struct Ring {
    double off = 0, held = 0, taxels = 0;
  };
  std::array<Ring, kRings> rings;
  const contact::Ellipse ellipse = ellipse_of(at, 1);
  const double c = std::cos(ellipse.angle_rad), s = std::sin(ellipse.angle_rad);
  const double pull_x = std::cos(at[direction]), pull_y = std::sin(at[direction]);
  const double limit_pa = at[peak] * at[load] / (1 - at[margin]);
  const auto held = outer_.row(Sheet::value, Sheet::xx);
  for (std::size_t i = 0; i < count_; ++i) {
    const double along_a = (c * u_[i] + s * v_[i]) / ellipse.a_m,
                 along_b = (c * v_[i] - s * u_[i]) / ellipse.b_m;
    const auto which = static_cast<std::size_t>(std::hypot(along_a, along_b) * kRings);
    Ring& ring = rings[std::min(which, kRings - 1)];
    const auto row = static_cast<Eigen::Index>(count_ + i),
               across_row = static_cast<Eigen::Index>(2 * count_ + i);
    ring.off += noise_shear_ * (pull_x * residuals_[row] + pull_y * residuals_[across_row]);
    ring.held += limit_pa * held[i];
    ring.taxels += 1;
  }
  // What is left of the shear is noise and misfit: noise is hardly more than that of the pressure.
  constexpr double kMostNoise = 1.5;
  const double noise_pa = std::min(noise_shear_, kMostNoise * noise_normal_);
  double misfit = 0;
  int used = 0;
  for (const Ring& ring : rings) {
    if (ring.taxels < 1) continue;
    const double uneven = fit_.uneven_share * ring.held;
    misfit += ring.off * ring.off / (noise_pa * noise_pa * ring.taxels + uneven * uneven);
    ++used;
  }
  return used > 0 ? misfit / used : 0;
}

bool ImprintFit::describe(const ContactPatch& patch, const Minimum& minimum,
                          FrameEstimate& out) const noexcept {
  const Full& at = minimum.at;
  const Vector scale = minimum.hessian.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return false;
  const Square even = scale.asDiagonal() * minimum.hessian * scale.asDiagonal();
  const auto decomposed = even.ldlt();
  const auto unit = [&](int which) -> Vector {
    Vector column = Vector::Zero(scale.size());
    column[which] = 1;
    return decomposed.solve(column);
  };
  const double variance = unit(margin)[margin] * scale[margin] * scale[margin];
  const double load_variance = unit(load)[load] * scale[load] * scale[load];
  if (!(variance > 0) || !std::isfinite(variance)) return false;
  out.gamma = at[margin];
  out.sigma = std::sqrt(variance);
  const double mobilised = 1 - out.gamma;
  out.friction = at[load] / mobilised;
  out.friction_sigma =
      out.sigma < fit_.max_friction_share * mobilised && load_variance > 0
          ? out.friction * std::hypot(out.sigma / mobilised, std::sqrt(load_variance) / at[load])
          : std::numeric_limits<double>::infinity();
  const double c = patch.direction_x, s = patch.direction_y;
  out.center_x_m = patch.center_x_m + c * at[center_x] - s * at[center_y];
  out.center_y_m = patch.center_y_m + s * at[center_x] + c * at[center_y];
  out.radius_m = at[size];
  out.normal_n = 2.0 / 3 * std::numbers::pi * at[size] * at[size] * at[peak];
  out.shear_n = at[load] * out.normal_n;
  return true;
}

// As Fit::weigh_by_prior: the likelihood of each margin, with place and shape held and the load best for it.
void ImprintFit::weigh_by_prior(const Full& at, const Square& hessian, FrameEstimate& out) noexcept {
  const Square covariance = hessian.ldlt().solve(Square::Identity(hessian.rows(), hessian.cols()));
  const double held =
      1 / (hessian(margin, margin) - hessian(load, margin) * hessian(load, margin) / hessian(load, load));
  const double kept = held / covariance(margin, margin);
  const double share = kept > 0 && kept < 1 ? std::max(kept, fit_.min_profile_share) : 1;
  const double c = std::cos(at[direction]), s = std::sin(at[direction]);
  const double p = at[peak], wn = 1 / noise_normal_, ws = 1 / noise_shear_;
  const std::size_t n = count_;
  ProfileFriction friction;
  auto& profile = out.profile;
  const ImprintRows outer(outer_);
  for (std::size_t j = 0; j < MarginProfile::kSteps; ++j) {
    const double gamma = MarginProfile::gamma_of(j), k = std::cbrt(gamma), q = p / (1 - gamma);
    inner_.evaluate_values(ellipse_of(at, k), {u_.data(), n}, {v_.data(), n});
    const ImprintRows inner(inner_);
    double square = 0, product = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const FeltTensor o = outer.at(Sheet::value, i), m = combined(1, o, -k, inner.at(Sheet::value, i));
      const Felt g = felt_of(0, o, q, c, s, m);
      const double left_n = data_[static_cast<Eigen::Index>(i)] - p * o.nn,
                   left_x = data_[static_cast<Eigen::Index>(n + i)] - p * o.nx,
                   left_y = data_[static_cast<Eigen::Index>(2 * n + i)] - p * o.ny;
      square += wn * wn * g.n * g.n + ws * ws * (g.x * g.x + g.y * g.y);
      product += wn * wn * g.n * left_n + ws * ws * (g.x * left_x + g.y * left_y);
    }
    const double t = std::max(fit_.min_traction_ratio, product / square);
    friction[j] = t / (1 - gamma);
    profile.misfit[j] = share * 0.5 * (t * t * square - 2 * t * product);
  }
  weigh_profile(friction, prior_, out);
}

// Round first; anew from another margin where it ends at an end of the range; then what noise is left over,
// and the ellipse if there is one.
ImprintFit::Minimum ImprintFit::fit_contact(const ContactPatch& patch, const MomentRatio& ratio) noexcept {
  Minimum best;
  best.at = start(patch, ratio);
  const double floor_pa = fit_.noise_floor * best.at[peak];
  const bool skin = depth_m_ > 0;
  noise_normal_ = std::max(patch.noise_normal_pa, floor_pa);
  noise_shear_ = skin ? noise_normal_ : std::max(patch.noise_shear_pa, floor_pa);
  minimise(kRound, best);
  if (best.at[margin] < fit_.min_start || best.at[margin] > fit_.max_start) {
    Minimum other;
    other.at = start(patch, ratio);
    other.at[margin] = options_.other_gamma;
    minimise(kRound, other);
    if (other.cost < best.cost) best = other;
  }
  // Where only the noise's size changes, and not that of one channel against the others, the minimum stays.
  const auto weights_changed = [&](int unknowns) {
    const double before = noise_shear_ / noise_normal_;
    evaluate(best.at, unknowns, best.gradient, best.hessian);
    measure_noise(best, unknowns);
    return std::fabs(std::log(noise_shear_ / noise_normal_ / before)) > options_.other_weights;
  };
  const bool changed = skin && weights_changed(kRound);
  elliptic_ = shows_ellipse(best);
  const int unknowns = elliptic_ ? int{kMost} : int{kRound};
  if (elliptic_ || changed) minimise(unknowns, best);
  if (skin && elliptic_ && weights_changed(unknowns)) minimise(unknowns, best);
  best.cost = evaluate(best.at, unknowns, best.gradient, best.hessian);
  return best;
}

double ImprintFit::least_sigma(const KnownImprint& truth, double noise_share) noexcept {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  count_ = layout_.size();
  const double c = std::cos(truth.pull_rad), s = std::sin(truth.pull_rad);
  for (std::size_t i = 0; i < count_; ++i) {
    const double x = layout_.x_m()[i] - truth.x_m, y = layout_.y_m()[i] - truth.y_m;
    x_[i] = c * x + s * y;
    y_[i] = c * y - s * x;
  }
  data_.setZero();
  noise_normal_ = noise_shear_ = 1;
  const contact::Ellipse& ellipse = truth.ellipse;
  const double log_axes = std::log(ellipse.a_m / ellipse.b_m),
               twice = 2 * (ellipse.angle_rad - truth.pull_rad);
  Full at = Full::Zero();
  at[size] = std::sqrt(ellipse.a_m * ellipse.b_m);
  at[peak] = 1;
  at[load] = truth.load;
  at[margin] = truth.gamma;
  at[along] = log_axes * std::cos(twice);
  at[across] = log_axes * std::sin(twice);
  Vector gradient;
  Square hessian;
  evaluate(at, ellipse.round() ? int{kRound} : int{kMost}, gradient, hessian);
  const double greatest = residuals_.head(static_cast<Eigen::Index>(count_)).maxCoeff();
  const Vector scale = hessian.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return kInfinite;
  const Square even = scale.asDiagonal() * hessian * scale.asDiagonal();
  Vector unit = Vector::Zero(scale.size());
  unit[margin] = 1;
  const Vector column = even.ldlt().solve(unit);
  const double variance = column[margin] * scale[margin] * scale[margin];
  return variance > 0 && std::isfinite(variance) ? noise_share * greatest * std::sqrt(variance) : kInfinite;
}

FrameEstimate ImprintFit::estimate(const ContactPatch& patch, const MomentRatio& ratio) noexcept {
  FrameEstimate out;
  steps_ = 0;
  elliptic_ = false;
  collect(patch);
  if (!(ratio.load > 0) || count_ < kMost) return out;
  const Minimum minimum = fit_contact(patch, ratio);
  const Full& at = minimum.at;
  if (!(at[load] > 0)) return out;  // the same contact, pulled the other way
  if (layout_.size() <= kFewTaxels) {
    weigh_by_prior(at, minimum.hessian, out);
    out.in_model = minimum.converged;
    return out;
  }
  if (!minimum.converged || !describe(patch, minimum, out)) return out;
  const double residual = residual_pressure(at), misfit = ring_misfit(at);
  if (out.sigma > fit_.open_sigma) weigh_by_prior(at, minimum.hessian, out);
  out.in_model = residual < options_.max_residual && misfit < fit_.max_ring_misfit;
  out.common_sigma = fit_.pressure_sigma * residual;
  out.sigma = std::hypot(out.sigma, out.common_sigma);
  out.friction_sigma =
      std::hypot(out.friction_sigma, fit_.friction_sigma_factor * out.common_sigma * out.friction);
  return out;
}

}  // namespace slipd
