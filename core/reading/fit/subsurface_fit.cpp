#include "core/reading/fit/subsurface_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "core/contact/subsurface/subsurface.hpp"
#include "core/frame/few_taxels.hpp"
#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/numeric/bounded_step.hpp"
#include "core/numeric/iteration.hpp"
#include "core/numeric/norm.hpp"
#include "core/patch/rings.hpp"
#include "core/reading/method/method.hpp"
#include "core/reading/method/profile_posterior.hpp"

namespace slipd {
namespace {

// From which the fit starts under a skin. If it ends nearer to 0 or 1 than FitOptions::start_within it starts
// anew, as far from 1.
constexpr double kMiddleGamma = 0.5;

using Model = ContactShape;
using Sheet = contact::SubsurfaceSheet;

double squares_of(std::span<const double> values) noexcept {
  double sum = 0;
#pragma omp simd reduction(+ : sum)
  for (std::size_t i = 0; i < values.size(); ++i) sum += values[i] * values[i];
  return sum;
}

}  // namespace

SubsurfaceFit::SubsurfaceFit(const TaxelLayout& layout, Range friction_expected, double depth_m,
                             const FitOptions& fit, const SubsurfaceFitOptions& options, double depth_sigma,
                             std::optional<double> bonded_poisson)
    : layout_(layout),
      fit_(fit),
      options_(options),
      prior_{.expected = friction_expected, .spread = fit.prior.scene_spread},
      depth_m_(depth_m),
      bonded_(depth_m > 0 && bonded_poisson),
      depth_(depth_m, depth_sigma),
      model_(layout, depth_m, bonded_poisson),
      shear_(3 * layout.size()),
      unsheared_(3 * layout.size()),
      columns_(depth_m > 0 ? 3 * moment_columns() * layout.size() : 0) {}

// The sensed pressure is wider than the one that acts, and its centre is drawn along the pull, by d Q/P. The
// disc reads less of the pull than of the pressure.
SubsurfaceFit::Full SubsurfaceFit::start(const ContactPatch& patch, const MomentRatio& ratio) const noexcept {
  constexpr double kLeastShare = 0.4, kMostEllipticity = 0.8;
  const double sensed = patch.radius_m, sensed_m2 = sensed * sensed;
  const double mean_m2 = std::max(sensed_m2 - options_.start_spread * depth_m_ * depth_m_,
                                  kLeastShare * kLeastShare * sensed_m2);  // of both axes
  const double e =
      frame_.elliptic ? std::min(ratio.deviation.ellipticity * sensed_m2 / mean_m2, kMostEllipticity) : 0;
  const double a = std::sqrt(mean_m2 * std::sqrt(1 - e * e)), twice = 2 * ratio.deviation.long_axis_rad;
  Full at = Full::Zero();
  at[Model::load] = ratio.load * (1 + options_.start_spread * depth_m_ / sensed);
  at[Model::center_x] = patch.center_x_m - depth_m_ * ratio.load * patch.direction_x;
  at[Model::center_y] = patch.center_y_m - depth_m_ * ratio.load * patch.direction_y;
  at[Model::direction] = std::atan2(patch.direction_y, patch.direction_x);
  at[Model::size] = a;
  at[Model::depth] = depth_.now().mean;
  at[Model::peak] = 1.5 * patch.normal_n / (std::numbers::pi * a * a);
  at[Model::margin] = depth_m_ > 0 ? kMiddleGamma : fit_.away_from_ends(gamma_of_moment_ratio(ratio.value));
  at[Model::along] = std::atanh(e) * std::cos(twice);
  at[Model::across] = std::atanh(e) * std::sin(twice);
  return at;
}

SubsurfaceFit::Full SubsurfaceFit::stepped(const Full& from, const Vector& step) const noexcept {
  constexpr double kMostFall = 3;  // of the peak pressure in one step: it stays above 0
  Full to = from;
  to.head(step.size()) += step;
  to[Model::margin] = std::clamp(to[Model::margin], fit_.min_gamma, fit_.max_gamma);
  to[Model::size] = std::clamp(to[Model::size], from[Model::size] / fit_.max_radius_factor,
                               from[Model::size] * fit_.max_radius_factor);
  to[Model::depth] = std::clamp(to[Model::depth], -depth_.most(), depth_.most());
  const double apart = norm(to[Model::along], to[Model::across]);
  if (apart > options_.max_log_axes) {
    to[Model::along] *= options_.max_log_axes / apart;
    to[Model::across] *= options_.max_log_axes / apart;
  }
  if (to.allFinite()) to[Model::peak] = std::max(to[Model::peak], from[Model::peak] / kMostFall);
  return to;
}

void SubsurfaceFit::minimise(int unknowns, Minimum& best) noexcept {
  Model::Normal trial_normal;
  double damping = fit_.first_damping, gained = std::numeric_limits<double>::infinity();
  best.converged = false;
  if (!best.known) {
    best.current = false;
    refresh(unknowns, best);
  }
  for (int step_number = 0; step_number < kMostSteps && !best.converged; ++step_number, ++frame_.steps) {
    const double gamma = best.evaluated[Model::margin];
    const Vector step = bounded_step(best.normal.hessian, best.normal.gradient, damping, Model::margin,
                                     fit_.min_gamma - gamma, fit_.max_gamma - gamma);
    const Full trial = stepped(best.evaluated, step);
    if (!trial.allFinite()) break;
    // Half the squared length of the step in standard deviations, as it would be without damping.
    if (gained < options_.settled_nats ||
        -0.5 * (1 + damping) * step.dot(best.normal.gradient) < options_.settled_nats) {
      best.at = trial;
      best.converged = true;
      break;
    }
    evaluate(trial, unknowns, trial_normal);
    best.current = trial_normal.cost <= best.normal.cost;
    if (best.current) {
      gained = best.normal.cost - trial_normal.cost;
      best.at = best.evaluated = trial;
      best.normal = trial_normal;
      damping /= fit_.damping_factor;
    } else {
      damping = std::max(fit_.first_damping, damping * fit_.damping_factor);
    }
  }
}

void SubsurfaceFit::refresh(int unknowns, Minimum& best) noexcept {
  if (best.current) return;
  if (!best.known) best.evaluated = best.at;
  evaluate(best.evaluated, unknowns, best.normal);
  best.known = best.current = true;
}

// Noise: root mean squares of what is left over, each channel with its share of the unknowns.
bool SubsurfaceFit::weights_change(int unknowns, Minimum& best) noexcept {
  const auto taxels = static_cast<double>(model_.count());
  const double used = 1 - unknowns / (3 * taxels), floor_pa = kExactShare * best.at[Model::peak];
  const Model::Noise before = model_.noise();
  const auto left = [&](const Model::Sums& of, double values) {
    return std::sqrt(2 * of.cost / (used * values));
  };
  const Model::Noise after{std::max(floor_pa, before.normal_pa * left(best.normal.of_pressure, taxels)),
                           std::max(floor_pa, before.shear_pa * left(best.normal.of_shear, 2 * taxels))};
  model_.change_noise(after);
  best.normal.change_noise(before, after);
  weigh_depth(best.evaluated, best.normal);
  return std::fabs(std::log(before.normal_pa * after.shear_pa / (after.normal_pa * before.shear_pa))) >
         options_.other_weights;
}

bool SubsurfaceFit::shows_ellipse(Minimum& round) noexcept {
  refresh(Model::kRound, round);
  return model_.axes_sigmas2(round.evaluated) > kClearSigmas * kClearSigmas;
}

void SubsurfaceFit::place(const Full& at, Reading& out) noexcept {
  out.center_x_m = at[Model::center_x];
  out.center_y_m = at[Model::center_y];
  out.radius_m = at[Model::size];
}

// What the shear alone makes each taxel read for one Q/P, over it: `of_shear` of each channel.
void SubsurfaceFit::fill_shear(const Full& at, double gamma, const Sheet& outer) noexcept {
  const double k = std::cbrt(gamma), q = at[Model::peak] / (1 - gamma);
  const double x = q * std::cos(at[Model::direction]), y = q * std::sin(at[Model::direction]);
  const SensedRows inner = sensed_rows(model_.show_part(at, k, profile_detail()), Sheet::value);
  fill_column(shear_.data(), {.dome = sensed_rows(outer, Sheet::value),
                              .other = inner,
                              .pulled_x_pa = x,
                              .pulled_y_pa = y,
                              .other_x_pa = -k * x,
                              .other_y_pa = -k * y});
}

void SubsurfaceFit::weigh_by_prior(const Full& at, double share, Reading& out) noexcept {
  const std::size_t rows = 3 * model_.count();
  const Sheet& outer = model_.show(at, profile_detail());
  const auto residuals = model_.residuals();
  fill_shear(at, at[Model::margin], outer);
  for (std::size_t i = 0; i < rows; ++i) unsheared_[i] = at[Model::load] * shear_[i] - residuals[i];
  ProfileSums sums;
  for (std::size_t j = 0; j < MarginProfile::kSteps; ++j) {
    fill_shear(at, MarginProfile::gamma_of(j), outer);
    std::array<double, 3> products;
    multiply_columns(std::array<const double*, 2>{shear_.data(), unsheared_.data()}, rows, products.data());
    sums.squares[j] = products[0];
    sums.products[j] = products[1];
  }
  weigh_profile(sums, share, prior_, out);
}

// As an ellipse where the pressure's moments show one, else round; anew from another margin where it ends at
// an end of the range; then with the noise that is left over, and as what the taxels show.
void SubsurfaceFit::fit_part(const ContactPatch& patch, const MomentRatio& ratio, Minimum& best) noexcept {
  model_.use_part(kSampled);
  frame_.elliptic = shows_ellipse(ratio.deviation);
  best.at = start(patch, ratio);
  minimise(unknowns(), best);
  if (const double gamma = best.at[Model::margin]; gamma != fit_.away_from_ends(gamma)) {
    Minimum other;
    other.at = start(patch, ratio);
    other.at[Model::margin] = fit_.away_from_ends(1);
    minimise(unknowns(), other);
    best.current = false;
    if (other.normal.cost < best.normal.cost) best = other;
  }
  const bool changed = (frame_.elliptic || depth_m_ > 0) && weights_change(unknowns(), best);
  const bool elliptic = frame_.elliptic ? Model::axes_sigmas2(best.normal.hessian, best.at.tail<2>()) >
                                              kClearSigmas * kClearSigmas
                                        : shows_ellipse(best);
  if (elliptic != frame_.elliptic) {
    best.known = false;
    best.at.tail<2>().setZero();
  }
  frame_.elliptic = elliptic;
  if (changed || !best.known) minimise(unknowns(), best);
}

void SubsurfaceFit::fit_all(Minimum& best) noexcept {
  model_.use_all();
  // At an end of its range the margin has no slope to come back by.
  best.at[Model::margin] = fit_.away_from_ends(best.at[Model::margin]);
  best.known = false;
  minimise(unknowns(), best);
  if (!best.converged) {  // from afar it takes another way
    Minimum other = best;
    other.at[Model::margin] = kMiddleGamma;
    other.known = false;
    minimise(unknowns(), other);
    best.current = false;
    if (other.converged) best = other;
  }
  if (weights_change(unknowns(), best)) minimise(unknowns(), best);
  if (!frame_.elliptic && shows_ellipse(best)) {
    frame_.elliptic = true;
    best.known = false;
    minimise(unknowns(), best);
    if (weights_change(unknowns(), best)) minimise(unknowns(), best);
  }
  refresh(unknowns(), best);
}

SubsurfaceFit::Minimum SubsurfaceFit::fit_contact(const ContactPatch& patch,
                                                  const MomentRatio& ratio) noexcept {
  Minimum best;
  begin_depth();
  const double floor_pa = kExactShare * start(patch, ratio)[Model::peak],
               normal_pa = std::max(patch.noise_normal_pa, floor_pa);
  model_.set_noise({normal_pa, depth_m_ > 0 ? normal_pa : std::max(patch.noise_shear_pa, floor_pa)});
  fit_part(patch, ratio, best);
  fit_all(best);
  take_depth(best);
  return best;
}

// Of an ellipse without a skin no more than what is pressed: the disc is too short for it, and too wide. A
// skin hides most of an ellipse.
contact::Ellipse SubsurfaceFit::reach_of(const ContactPatch& patch,
                                         const HertzDeviation& deviation) const noexcept {
  // As of the disc that forces are summed over, see PatchOptions.
  constexpr double kReachFactor = 1.06, kReachSides = 0.71;
  const double e = depth_m_ > 0 ? 0 : deviation.ellipticity;
  const double beyond_m = kReachSides * layout_.side_m() + options_.reach_depths * depth_m_;
  const auto axis_m = [&](double stretch) {
    return kReachFactor * patch.radius_m * std::sqrt(stretch) + beyond_m;
  };
  return {axis_m(1 + e), axis_m(1 - e), deviation.long_axis_rad};
}

double SubsurfaceFit::layer_sigma(const Full& at) const noexcept {
  if (!bonded_) return 0;
  return kFarSigma * at[Model::margin] * std::clamp(at[Model::size] / depth_m_ - 1, 0.0, 1.0);
}

double SubsurfaceFit::misfit_nats() const noexcept {
  if (!frame_.fitted) return std::numeric_limits<double>::quiet_NaN();
  const std::size_t n = model_.count();
  const auto left = model_.residuals();
  const auto taxels = static_cast<double>(n);
  const double normal_pa = model_.noise().normal_pa * std::sqrt(squares_of(left.first(n)) / taxels),
               shear_pa = model_.noise().shear_pa * std::sqrt(squares_of(left.subspan(n)) / (2 * taxels));
  return taxels * (std::log(normal_pa) + 2 * std::log(shear_pa));
}

Reading SubsurfaceFit::estimate(const ContactPatch& patch, const MomentRatio& ratio) noexcept {
  Reading out;
  frame_ = {};
  model_.collect(patch, reach_of(patch, ratio.deviation), kFewTaxels);
  if (!(ratio.load > 0) || model_.count() < Model::kMost) return out;
  const Minimum minimum = fit_contact(patch, ratio);
  frame_.fitted = true;
  read(patch, minimum, out);
  return out;
}

void SubsurfaceFit::read(const ContactPatch& patch, const Minimum& minimum, Reading& out) noexcept {
  const Full& at = minimum.at;
  if (!(at[Model::load] > 0)) return;  // the same contact, pulled the other way
  if (depth_m_ > 0) find_moments(patch, minimum.evaluated, out);
  if (!minimum.converged) return;
  const MarginParabola<Square> near = parabola(minimum);
  if (!near.describe(at[Model::margin], at[Model::load], out)) return;
  place(at, out);
  if (!(depth_m_ > 0)) {  // else find_moments has the forces, of any history
    out.normal_n = 2.0 / 3 * std::numbers::pi * at[Model::size] * at[Model::size] * at[Model::peak];
    out.shear_n = at[Model::load] * out.normal_n;
  }
  const auto held = model_.show(at, Model::Detail::rough).row(Sheet::value, Sheet::xx);
  const double residual = residual_pressure(at), misfit = ring_misfit(at, held);
  if (out.sigma > kOpenSigma) weigh_by_prior(minimum.evaluated, near.profile_share(), out);
  out.in_model = residual < options_.max_residual && misfit < kMaxRingMisfit && looks_monotonic(out);
  out.common_sigma = out.shape_sigma = kUnexplainedSigma * residual;
  if (depth_.open()) out.common_sigma = norm(out.common_sigma, margin_by_depth_ * depth_.now().sigma);
  out.common_sigma = norm(out.common_sigma, layer_sigma(at));
  out.sigma = norm(out.sigma, out.common_sigma);
  out.friction_sigma = norm(out.friction_sigma, out.common_sigma / (1 - out.gamma) * out.friction);
}

void FewTaxelsSubsurfaceFit::read(const ContactPatch& /*patch*/, const Minimum& minimum,
                                  Reading& out) noexcept {
  out.noise_normal_pa = model().noise().normal_pa;
  out.noise_shear_pa = model().noise().shear_pa;
  if (!(minimum.at[Model::load] > 0)) return;  // the same contact, pulled the other way
  weigh_by_prior(minimum.evaluated, parabola(minimum).profile_share(), out);
  place(minimum.at, out);
  out.in_model = minimum.converged;
}

std::unique_ptr<SubsurfaceFit> make_subsurface_fit(const TaxelLayout& layout, Range friction_expected,
                                                   const Skin& skin, const FitOptions& options) {
  if (layout.size() <= kFewTaxels)
    return std::make_unique<FewTaxelsSubsurfaceFit>(layout, friction_expected, skin.depth_m, options,
                                                    SubsurfaceFitOptions{}, skin.depth_sigma,
                                                    skin.bonded_poisson());
  return std::make_unique<SubsurfaceFit>(layout, friction_expected, skin.depth_m, options,
                                         SubsurfaceFitOptions{}, skin.depth_sigma, skin.bonded_poisson());
}

}  // namespace slipd
