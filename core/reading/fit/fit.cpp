#include "core/reading/fit/fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>

#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/numeric/bounded_step.hpp"
#include "core/numeric/iteration.hpp"
#include "core/numeric/norm.hpp"
#include "core/patch/rings.hpp"
#include "core/reading/fit/residual_sums.hpp"
#include "core/reading/method/method.hpp"
#include "core/reading/method/profile_posterior.hpp"
#include "core/reading/moments/moments.hpp"
#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

// k of each margin of a profile.
std::array<double, MarginProfile::kSteps> stick_shares() noexcept {
  std::array<double, MarginProfile::kSteps> shares{};
  for (std::size_t j = 0; j < shares.size(); ++j) shares[j] = std::cbrt(MarginProfile::gamma_of(j));
  return shares;
}
const std::array<double, MarginProfile::kSteps> kStickShares = stick_shares();
static_assert(contact::kRings == MarginProfile::kSteps);

double square(double value) noexcept {
  return value * value;
}

// Hertz: p0 = 3 P/(2 pi a^2).
double peak_pressure(const ContactPatch& patch) noexcept {
  return 1.5 * patch.normal_n / (std::numbers::pi * patch.radius_m * patch.radius_m);
}

}  // namespace

Fit::Fit(const TaxelLayout& layout, Range friction_expected, const FitOptions& options, FitSamples& samples)
    : layout_(layout),
      options_(options),
      prior_{.expected = friction_expected, .spread = options.prior.scene_spread},
      samples_(samples),
      contact_(samples.most()),
      stick_(samples.most()) {
  best_kernels<DomeProductKernels>();  // not first within a fit
}

std::size_t Fit::samples_bytes() const noexcept {
  constexpr std::size_t kListsOfADome = 4;
  return samples_.memory_bytes() + 2 * kListsOfADome * sizeof(double) * samples_.most();
}

void Fit::set_noise(const ContactPatch& patch) noexcept {
  const double floor_pa = kExactShare * peak_pressure(patch), along = samples_.taxels_along();
  frame_.noise_normal_pa = std::max(patch.noise_normal_pa, floor_pa) / along;
  frame_.noise_shear_pa = std::max(patch.noise_shear_pa, floor_pa * patch.shear_n / patch.normal_n) / along;
}

Fit::Vector Fit::start(const ContactPatch& patch, const MomentRatio& ratio) const noexcept {
  const double a = patch.radius_m;
  Vector at;
  at[center_x] = at[center_y] = 0;
  at[radius] = a;
  at[height] = 1.5 * patch.normal_n / (std::numbers::pi * a * a * a);
  at[load] = ratio.load;
  at[margin] = options_.away_from_ends(gamma_of_moment_ratio(ratio.value));
  return at;
}

double Fit::evaluate(Vector& at, Vector& gradient, Square& hessian) noexcept {
  gradient.setZero();
  hessian.setZero();
  const double gamma = at[margin], k = std::cbrt(gamma), rest = 1 - gamma, a = at[radius];
  samples_.average(a, at[center_x], at[center_y], contact_.averages());
  samples_.average(k * a, at[center_x], at[center_y], stick_.averages());
  const DomeTask task{.contact = contact_.pointers(),
                      .stick = stick_.pointers(),
                      .normal_pa = samples_.normal_pa().data(),
                      .shear_pa = samples_.shear_pa().data(),
                      .count = samples_.count(),
                      .stick_share = k};
  const DomeProductKernels& kernels = best_kernels<DomeProductKernels>();
  const DomeHeights heights = kernels.heights(task);
  if (!(heights.pressure > 0)) return std::numeric_limits<double>::infinity();
  DomeProducts products;
  kernels.products(task, heights, products);

  // Residuals are sums of the columns of DomeProducts; a row for each unknown says of which.
  const double b = heights.pressure, shear = heights.shear;
  at[height] = b;
  at[load] = shear * rest / b;
  Eigen::Matrix<double, kUnknowns, DomeProducts::kPressure - 1> pressures;
  pressures.setZero();
  pressures(center_x, DomeProducts::pressure_u) = pressures(center_y, DomeProducts::pressure_v) = -b;
  pressures(radius, DomeProducts::pressure_radius) = b;
  pressures(height, DomeProducts::pressure_value) = 1;
  Eigen::Matrix<double, kUnknowns, DomeProducts::kShear - 1> shears;
  shears.setZero();
  shears(center_x, DomeProducts::shear_u) = shears(center_y, DomeProducts::shear_v) = -shear;
  shears(radius, DomeProducts::shear_radius) = shear;
  shears(height, DomeProducts::shear_value) = shear / b;
  shears(load, DomeProducts::shear_value) = b / rest;
  shears(margin, DomeProducts::shear_value) = shear / rest;
  shears(margin, DomeProducts::shear_stick) = -shear * a / (3 * k * k);  // k a by Gamma

  double squares = 0;
  const auto add = [&](const auto& rows, const auto& packed, double noise_pa) {
    constexpr int kColumns = std::decay_t<decltype(rows)>::ColsAtCompileTime;
    Eigen::Matrix<double, kColumns + 1, kColumns + 1> sums;
    auto from = packed.begin();
    for (int row = 0; row <= kColumns; ++row) {
      for (int column = 0; column <= row; ++column) sums(row, column) = sums(column, row) = *from++;
    }
    sums /= noise_pa * noise_pa;
    hessian += rows * sums.template topLeftCorner<kColumns, kColumns>() * rows.transpose();
    gradient += rows * sums.template topRightCorner<kColumns, 1>();
    squares += sums(kColumns, kColumns);
  };
  add(pressures, products.pressure, frame_.noise_normal_pa);
  add(shears, products.shear, frame_.noise_shear_pa);
  // What the patch knows of place and size, to within that size: samples that all lie within the contact, or
  // one that holds it, show nothing of them.
  const Vector& first = frame_.first;
  const double place = 1 / square(first[radius] + layout_.side_m()), size = 1 / square(first[radius]);
  for (const auto& [unknown, weight] : {std::pair{center_x, place}, {center_y, place}, {radius, size}}) {
    const double off = at[unknown] - first[unknown];
    hessian(unknown, unknown) += weight;
    gradient[unknown] += weight * off;
    squares += weight * off * off;
  }
  return 0.5 * squares;
}

Fit::RingMisfit Fit::ring_misfit(const Vector& at) const noexcept {
  const double shape = at[height] * at[load] / (1 - at[margin]);
  ResidualRings rings;
  for (std::size_t i = 0; i < samples_.count(); ++i) {
    const double u = samples_.x_m()[i] - at[center_x], v = samples_.y_m()[i] - at[center_y];
    rings.add(std::sqrt(u * u + v * v) / at[radius],
              shape * (contact_.value[i] - stick_.value[i]) - samples_.shear_pa()[i],
              shape * contact_.value[i]);
  }
  return {rings.misfit(frame_.noise_shear_pa, 0), rings.misfit(frame_.noise_shear_pa, kUnevenShare)};
}

// As a share of the peak: a contact that is tilted, elliptic or sensed through a skin is off to one side or
// another, an array with dead taxels here and there. Shear is off by as much, and its residual does not show
// that, as the margin gives way to it.
double Fit::residual_pressure(const Vector& at) const noexcept {
  constexpr double kFitted = 4;  // unknowns of the pressure: place, radius, height
  ResidualParts parts(at[radius]);
  for (std::size_t i = 0; i < samples_.count(); ++i) {
    parts.add(samples_.x_m()[i] - at[center_x], samples_.y_m()[i] - at[center_y],
              samples_.normal_pa()[i] - at[height] * contact_.value[i]);
  }
  return parts.beyond_noise_pa(frame_.noise_normal_pa, kFitted) / (at[height] * at[radius]);
}

// Where noise leaves the margin open, the likelihood is no parabola about the best fit. The whole range is
// weighed instead: the likelihood of each margin, times the prior of the friction that it would need.
void Fit::weigh_by_prior(const Vector& at, double share, Reading& out) noexcept {
  contact::PerRing radii;
  for (std::size_t j = 0; j < radii.size(); ++j) radii[j] = static_cast<float>(kStickShares[j] * at[radius]);
  const contact::RingSums rings =
      samples_.ring_sums(radii, at[center_x], at[center_y], {contact_.value.data(), samples_.count()});
  ProfileSums sums;
  for (std::size_t j = 0; j < MarginProfile::kSteps; ++j) {
    const double slope = at[height] / ((1 - MarginProfile::gamma_of(j)) * frame_.noise_shear_pa);
    sums.squares[j] = slope * slope * rings.squares[j];
    sums.products[j] = slope * rings.products[j] / frame_.noise_shear_pa;
  }
  weigh_profile(sums, share, prior_, out);
}

Fit::Minimum Fit::minimise(const Vector& start) noexcept {
  Minimum best{start, {}, false};
  Vector gradient, trial_gradient;
  Square trial_hessian;
  double cost = evaluate(best.at, gradient, best.hessian), damping = options_.first_damping;
  if (!std::isfinite(cost)) return best;
  bool current = true;  // the domes are those of the best contact
  const double settled = options_.converged_sigmas * options_.converged_sigmas;
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
    // As long as it would be without damping, better or not.
    const Vector moved = (1 + damping) * (trial - best.at);
    best.converged = moved.dot(best.hessian * moved) < settled;
    current = trial_cost <= cost;
    if (current) {
      best.at = trial;
      cost = trial_cost;
      gradient = trial_gradient;
      best.hessian = trial_hessian;
      damping /= options_.damping_factor;
    } else {
      damping = std::max(options_.first_damping, damping * options_.damping_factor);
    }
  }
  if (!current) evaluate(best.at, gradient, best.hessian);
  return best;
}

bool Fit::take_last_step(Minimum& minimum) noexcept {
  Vector gradient;
  if (!std::isfinite(evaluate(minimum.at, gradient, minimum.hessian))) return false;
  const Vector step = -minimum.hessian.ldlt().solve(gradient);
  const double squares = -step.dot(gradient);  // of its length in standard deviations
  Vector at = minimum.at + step;
  at[margin] = std::clamp(at[margin], options_.min_gamma, options_.max_gamma);
  const double most = kStandsOutSigmas;
  if (!at.allFinite() || !(squares < most * most) || !(at[radius] > 0)) return false;
  const auto move = [&](Dome& dome, double by_radius) {
#pragma omp simd
    for (std::size_t i = 0; i < samples_.count(); ++i) {
      dome.value[i] += by_radius * dome.d_x[i] - step[center_x] * dome.d_u[i] - step[center_y] * dome.d_v[i];
    }
  };
  move(contact_, step[radius]);
  move(stick_, std::cbrt(at[margin]) * at[radius] - std::cbrt(minimum.at[margin]) * minimum.at[radius]);
  minimum.at = at;
  ++frame_.steps;
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
  set_noise(patch);
  const MomentRatio ratio = moment_ratio(patch, layout_, options_.ratio);
  Reading out;
  out.moments = ratio.moments;
  out.moments_sigma = ratio.moments_sigma;
  out.moments_common_sigma = ratio.moments_common_sigma;
  read(patch, ratio, out);
  return out;
}

std::optional<Fit::Vector> Fit::start_of(const ContactPatch& patch, const MomentRatio& ratio) noexcept {
  frame_.first = start(patch, ratio);
  if (!(frame_.first[load] > 0) || samples_.count() < kUnknowns) return std::nullopt;
  return frame_.first;
}

void Fit::conclude(const ContactPatch& patch, const MomentRatio& ratio, const Minimum& minimum,
                   Reading& out) noexcept {
  const Vector& at = minimum.at;
  if (!minimum.converged) return;
  const MarginParabola<Square> near = parabola(minimum);
  if (!near.describe(at[margin], at[load], out)) return;
  place(patch, at, out);
  const HertzDeviationOptions& deviation = options_.ratio.deviation;
  const RingMisfit misfit = ring_misfit(at);
  out.in_model = ratio.deviation.hertzian(deviation) && misfit.by_skin < kMaxRingMisfit;
  if (out.sigma > kOpenSigma) weigh_by_prior(at, near.profile_share(), out);
  // A residual beyond noise is taken for an uneven skin; it may as well be a little of another history.
  const double uneven = misfit.by_noise > kMaxRingMisfit ? kModelSigma : 0;
  const double unlike = std::max(kUnexplainedSigma * residual_pressure(at), ratio.deviation.sigma(deviation));
  const double model_sigma = norm(uneven, unlike);
  out.sigma = norm(out.sigma, model_sigma);
  out.common_sigma = model_sigma;
  out.friction_sigma = norm(out.friction_sigma, model_sigma / (1 - out.gamma) * out.friction);
}

}  // namespace slipd
