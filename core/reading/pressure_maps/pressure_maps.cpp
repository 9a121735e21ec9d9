#include "core/reading/pressure_maps/pressure_maps.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/health/usual.hpp"
#include "core/load/load_path.hpp"
#include "core/numeric/norm.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {
namespace {

// Taxels of the maps that are filtered in one frame, under a skin, while the gripper closes; for an estimate
// least_maps times as many; 1000 … 100000, at least one map. Too few: after a quick grip, margins come late.
// Too many: single frames take long.
constexpr std::size_t kFilteredInClosing = 4096;

}  // namespace

PressureMaps::PressureMaps(const TaxelLayout& layout, Range friction_expected, const Skin& skin,
                           const PressureMapsOptions& options)
    : layout_(layout),
      prior_{.expected = friction_expected, .spread = options.prior.scene_spread},
      options_(options),
      maps_(layout.size(), skin.depth_m > 0),
      shear_pa_(layout.size()) {
  if (skin.depth_m > 0) skin_.emplace(layout, skin, kSteps);
}

double PressureMaps::force_n(const ContactPatch& patch) const noexcept {
  if (!skin_) return patch.normal_n;
  double sum_pa = 0;
  for (std::size_t i = 0; i < layout_.size(); ++i) sum_pa += patch.taxels.normal_pa[i];
  return layout_.area_m2() * sum_pa;
}

void PressureMaps::observe(const Frame&, const ContactPatch& patch) noexcept {
  if (!(patch.normal_n > 0) || patch.normal_n < kStandsOutSigmas * patch.normal_sigma_n) return;
  const double normal_n = force_n(patch);
  if (skin_ && patch.shear_n > kPulled * patch.normal_n &&
      patch.shear_n > kStandsOutSigmas * patch.shear_sigma_n)
    pulled_n_ = std::max(pulled_n_, normal_n);
  if (!(normal_n > 0) || normal_n < kGrown * pulled_n_) return;
  const bool pulled = patch.shear_n > (skin_ ? options_.most_shear_sensed : kPulled) * patch.normal_n &&
                      patch.shear_n > kClearSigmas * patch.shear_sigma_n;
  if (pulled && (skin_ || !grown(patch, normal_n))) return;
  // Under a skin only while the force rises: the first of a pull in a held grip would be taken for what
  // pressing is sensed as.
  if ((!skin_ || normal_n > most_n_) && maps_.frames_like(normal_n) < learning_frames())
    maps_.add(patch.taxels, normal_n);
  most_n_ = std::max(most_n_, normal_n);
  if (skin_) skin_->prepare(maps_, kFilteredInClosing, maps_.slot_of(normal_n));
}

bool PressureMaps::grown(const ContactPatch& patch, double normal_n) noexcept {
  if (!recorded(normal_n) || normal_n <= maps_.force_n(maps_.size() - 1) ||
      maps_.frames_like(normal_n) >= learning_frames())
    return false;
  maps_.find_contact(patch.noise_normal_pa);
  return unmoved(patch, maps_.at(normal_n));
}

bool PressureMaps::recorded(double normal_n) const noexcept {
  return maps_.size() >= options_.least_maps && maps_.force_n(0) <= normal_n / kGrown &&
         normal_n <= options_.most_step * (skin_ ? most_n_ : maps_.force_n(maps_.size() - 1));
}

bool PressureMaps::unmoved(const ContactPatch& patch, const RecordedMaps::Sum& today) const noexcept {
  const std::span<const float> pressure(patch.taxels.normal_pa, layout_.size());
  const double noise_pa2 = patch.noise_normal_pa * patch.noise_normal_pa;
  double square_pa2 = 0;
  for (const float value : pressure) square_pa2 += static_cast<double>(value) * value;
  square_pa2 -= static_cast<double>(layout_.size()) * noise_pa2;
  const double map_pa2 = maps_.square_pa2(today, patch.noise_normal_pa);
  const double product_pa2 = RecordedMaps::product(today, maps_.products(pressure));
  if (!(square_pa2 > 0 && map_pa2 > 0)) return false;
  return 1 - product_pa2 * product_pa2 / (square_pa2 * map_pa2) < kUnlike;
}

PressureMaps::Trial PressureMaps::judge(double gamma, const ContactPatch& patch,
                                        const RecordedMaps::Sum& today, const RecordedMaps::PerMap& products,
                                        double shear_square_pa2) const noexcept {
  const RecordedMaps::Sum slipping = RecordedMaps::difference(today, maps_.at(gamma * patch.normal_n));
  const double product_pa2 = RecordedMaps::product(slipping, products);
  const double square_pa2 = maps_.square_pa2(slipping, patch.noise_normal_pa);
  Trial trial{.gamma = gamma};
  if (!(square_pa2 > 0)) return trial;
  const double measured = product_pa2 / square_pa2, friction = std::max(0.0, measured);
  const double shear_pa2 = patch.noise_shear_pa * patch.noise_shear_pa;
  const double map_pa = friction * patch.noise_normal_pa;
  const double noise_share = maps_.noise_share(slipping), map_pa2 = map_pa * map_pa * noise_share;
  trial.noise_pa2 = std::max(shear_pa2 + map_pa2, std::numeric_limits<double>::min());
  trial.map_share = map_pa2 / trial.noise_pa2;
  const auto taxels = static_cast<double>(maps_.contact().size());
  // Of the maps as they are, with their noise.
  const double noisy_pa2 = square_pa2 + taxels * patch.noise_normal_pa * patch.noise_normal_pa * noise_share;
  trial.residual_pa2 =
      std::max(0.0, shear_square_pa2 - 2 * friction * product_pa2 + friction * friction * noisy_pa2);
  trial.misfit = 0.5 * (trial.residual_pa2 / trial.noise_pa2 + taxels * std::log(trial.noise_pa2));
  weigh_friction(measured, square_pa2, trial);
  return trial;
}

void PressureMaps::weigh_friction(double measured, double square_pa2, Trial& trial) const noexcept {
  const FrictionPrior::Weighed weighed = prior_.weigh(measured, square_pa2 / trial.noise_pa2);
  trial.friction = weighed.mu;
  trial.nats = weighed.nats;
}

// Means over the likelihood of all margins: it need not be a parabola.
void PressureMaps::weigh(Reading& out) const noexcept {
  double least = std::numeric_limits<double>::infinity();
  for (const Trial& trial : trials_) {
    if (trial.friction > 0) least = std::min(least, trial.misfit + trial.nats);
  }
  double weights = 0, mean = 0, square = 0, friction = 0, friction_square = 0;
  for (const Trial& trial : trials_) {
    if (trial.friction <= 0) continue;
    const double weight = std::exp(least - trial.misfit - trial.nats);
    weights += weight;
    mean += weight * trial.gamma;
    square += weight * trial.gamma * trial.gamma;
    friction += weight * trial.friction;
    friction_square += weight * trial.friction * trial.friction;
  }
  if (!(weights > 0)) return;
  out.in_model = true;
  out.gamma = mean / weights;
  out.sigma = std::sqrt(std::max(0.0, square / weights - out.gamma * out.gamma));
  out.friction = friction / weights;
  out.friction_sigma = std::sqrt(std::max(0.0, friction_square / weights - out.friction * out.friction));
}

// Without the prior.
void PressureMaps::give_profile(Reading& out) const noexcept {
  constexpr double kNone = 50;  // nats against a margin that would need a friction below 0
  double least = std::numeric_limits<double>::infinity();
  for (const Trial& trial : trials_) {
    if (trial.friction > 0) least = std::min(least, trial.misfit);
  }
  for (std::size_t j = 0; j < MarginProfile::kSteps; ++j) {
    const Trial& trial = trials_[kStepsOfProfile * j + kStepsOfProfile / 2];
    out.profile.misfit[j] = trial.friction > 0 ? std::min(kNone, trial.misfit - least) : kNone;
  }
  out.profile.known = true;
}

const PressureMaps::Trial* PressureMaps::best_trial() const noexcept {
  const Trial* best = nullptr;
  for (const Trial& trial : trials_) {
    if (trial.friction > 0 && (best == nullptr || trial.misfit + trial.nats < best->misfit + best->nats))
      best = &trial;
  }
  return best;
}

double PressureMaps::unexplained_share(const Squares& squares) const noexcept {
  if (!(squares.excess_pa2 > kClearSigmas * squares.noise_pa2)) return 0;
  return std::sqrt(squares.excess_pa2 / std::max(squares.explained_pa2, squares.excess_pa2));
}

void PressureMaps::give_moments(const JaegerDecomposition& sum, const Squares& squares,
                                Reading& out) const noexcept {
  if (unexplained_share(squares) > kMostUnexplained) return;
  out.moments = sum.moments();
  out.moments_sigma = sum.sigma();
  out.moments_common_sigma = sum.common_sigma();
  if (!skin_ || !(sum.shear_n() > 0)) return;
  out.normal_n = sum.normal_n();
  out.shear_n = sum.shear_n();
}

void PressureMaps::conclude(const ContactPatch& patch, const Trial& best, const Squares& squares,
                            Reading& out) const noexcept {
  const double unexplained = unexplained_share(squares);
  if (unexplained > kMostUnexplained) return;
  weigh(out);
  if (!out.in_model) return;
  if (out.sigma > kOpenSigma && !skin_) give_profile(out);
  const double by_model = norm(kUnevenShare, kUnexplainedSigma * unexplained);
  out.common_sigma = norm(by_model, out.sigma * std::sqrt(best.map_share));
  out.sigma = norm(out.sigma, by_model);
  const double rest = 1 - out.gamma;
  if (!(out.sigma < kKnownFrictionShare * rest))
    out.friction_sigma = std::numeric_limits<double>::infinity();
  else
    out.friction_sigma = norm(out.friction_sigma, out.friction * by_model / rest);
  out.center_x_m = patch.center_x_m;
  out.center_y_m = patch.center_y_m;
  out.radius_m = patch.radius_m;
}

bool PressureMaps::superpose(const ContactPatch& patch, const RecordedMaps::PerMap& products,
                             double shear_square_pa2, JaegerDecomposition& out) const noexcept {
  const double floor_pa2 = std::numeric_limits<double>::min();
  JaegerDecomposition::Read sums{
      .products = {},
      .noise_shares = {},
      .sensed = {},
      .shear_pa2 = shear_square_pa2,
      .values = static_cast<double>(maps_.contact().size()),
      .noise_pa2 = std::max(patch.noise_shear_pa * patch.noise_shear_pa, floor_pa2),
      .map_noise_pa2 = patch.noise_normal_pa * patch.noise_normal_pa};
  std::array<RecordedMaps::Sum, JaegerDecomposition::kTerms> terms;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    terms[i] = maps_.at(JaegerDecomposition::kShares[i] * patch.normal_n);
    for (std::size_t k = 0; k < RecordedMaps::Sum::kTerms; ++k)
      out.add(i, maps_.force_n(terms[i].map[k]), terms[i].weight[k]);
    const auto row = static_cast<Eigen::Index>(i);
    sums.sensed[row] = RecordedMaps::product(terms[i], products);
    for (std::size_t j = 0; j <= i; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      sums.noise_shares(row, column) = sums.noise_shares(column, row) = maps_.noise_share(terms[i], terms[j]);
      sums.products(row, column) = sums.products(column, row) = maps_.product_pa2(terms[i], terms[j], 0);
    }
  }
  return out.solve(sums);
}

Reading PressureMaps::estimate(const Frame&, const ContactPatch& patch) noexcept {
  if (skin_) return estimate_sensed(patch);
  Reading out;
  if (!recorded(patch.normal_n)) return out;
  maps_.find_contact(patch.noise_normal_pa);
  const RecordedMaps::Sum today = maps_.at(patch.normal_n);
  if (!unmoved(patch, today)) return out;
  double shear_square_pa2 = 0, across_pa2 = 0;
  for (const std::uint32_t i : maps_.contact()) {
    shear_pa_[i] = static_cast<float>(patch.shear_along_pa(i));
    shear_square_pa2 += static_cast<double>(shear_pa_[i]) * shear_pa_[i];
    const double across_pa =
        patch.direction_x * patch.taxels.shear_y_pa[i] - patch.direction_y * patch.taxels.shear_x_pa[i];
    across_pa2 += across_pa * across_pa;
  }
  const auto taxels = static_cast<double>(maps_.contact().size());
  // Shear across the pull is none of a load that came in one direction.
  const double noise_pa2 = patch.noise_shear_pa * patch.noise_shear_pa;
  across_pa2 = std::max(0.0, across_pa2 - taxels * noise_pa2);
  const RecordedMaps::PerMap products = maps_.products(shear_pa_);
  if (JaegerDecomposition sum(patch.normal_n); superpose(patch, products, shear_square_pa2, sum)) {
    give_moments(sum,
                 {.excess_pa2 = sum.excess_pa2() + across_pa2,
                  .noise_pa2 = noise_pa2 * std::sqrt(2 * taxels),
                  .explained_pa2 = shear_square_pa2 - taxels * noise_pa2 - sum.excess_pa2()},
                 out);
  }
  for (std::size_t i = 0; i < kSteps; ++i)
    trials_[i] = judge(gamma_of(i), patch, today, products, shear_square_pa2);
  const Trial* const best = best_trial();
  if (best == nullptr) return out;
  conclude(patch, *best,
           {.excess_pa2 = best->residual_pa2 - best->noise_pa2 * taxels + across_pa2,
            .noise_pa2 = best->noise_pa2 * std::sqrt(2 * taxels),
            .explained_pa2 = shear_square_pa2 - best->residual_pa2},
           out);
  return out;
}

PressureMaps::Trial PressureMaps::judge_sensed(std::size_t step, const ContactPatch& patch) const noexcept {
  const SubsurfacePressureMaps::Pull pull = skin_->pull(step);
  Trial trial{.gamma = gamma_of(step)};
  if (!(pull.noise_pa2 > 0)) return trial;
  trial.residual_pa2 = pull.residual_pa2;
  trial.noise_pa2 = pull.noise_pa2;
  // Both maps' noise is the same in all frames: the difference's, and that of what pressing is sensed as.
  trial.map_share = std::min(1.0, pull.map_share + skin_->pressing_share());
  // Against the force: noise.
  const double along = pull.x * patch.direction_x + pull.y * patch.direction_y;
  weigh_friction(along > 0 ? norm(pull.x, pull.y) : along, pull.square_pa2, trial);
  return trial;
}

// The maps are the same ones for all margins. So their noise is taken off each residual, and does not speak
// against margins that need more friction.
std::size_t PressureMaps::judge_sensed(const ContactPatch& patch) noexcept {
  std::size_t best = kSteps;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kSteps; ++i) {
    const Trial trial = trials_[i] = judge_sensed(i, patch);
    const double nats = 0.5 * trial.residual_pa2 / trial.noise_pa2 + trial.nats;
    if (!(trial.friction > 0 && nats < least)) continue;
    best = i;
    least = nats;
  }
  if (best == kSteps) return best;
  const double noise_pa2 = trials_[best].noise_pa2;
  for (Trial& trial : trials_) trial.misfit = 0.5 * trial.residual_pa2 / noise_pa2;
  return best;
}

std::size_t PressureMaps::closest_trial() const noexcept {
  std::size_t closest = kSteps;
  for (std::size_t i = 0; i < kSteps; ++i) {
    if (trials_[i].friction > 0 &&
        (closest == kSteps || trials_[i].residual_pa2 < trials_[closest].residual_pa2))
      closest = i;
  }
  return closest;
}

// The same frame, read as if the taxels lay deeper.
double PressureMaps::sigma_by_depth(const ContactPatch& patch, std::size_t best, double gamma) noexcept {
  if (!(std::fabs(gamma - asked_at_gamma_) > kModelSigma)) return by_depth_;
  skin_->deepen(maps_, best, skin_->pull(best));
  judge_sensed(patch);
  Reading deeper;
  weigh(deeper);
  asked_at_gamma_ = gamma;
  by_depth_ = deeper.in_model
                  ? std::fabs(deeper.gamma - gamma) / SubsurfacePressureMaps::kDeeper * skin_->depth_sigma()
                  : 1;
  return by_depth_;
}

bool PressureMaps::read_sensed(const ContactPatch& patch, double normal_n, SensedFrame& out) noexcept {
  skin_->prepare(maps_, options_.least_maps * kFilteredInClosing);
  if (!skin_->ready(maps_)) return false;
  skin_->read(patch.taxels, maps_, normal_n);
  out.best = judge_sensed(patch);
  out.sum = JaegerDecomposition(normal_n);
  out.summed = skin_->superpose(maps_, normal_n, patch.direction_x, patch.direction_y, out.sum);
  if (out.summed) return skin_->unlike_superposed(maps_, patch.direction_x, patch.direction_y) < kUnlike;
  return out.best < kSteps && skin_->unlike(maps_, out.best, skin_->pull(out.best)) < kUnlike;
}

Reading PressureMaps::estimate_sensed(const ContactPatch& patch) noexcept {
  Reading out;
  const double normal_n = force_n(patch);
  if (!recorded(normal_n)) return out;
  SensedFrame sensed;
  if (!read_sensed(patch, normal_n, sensed)) return out;
  // The grip has tightened since it closed.
  if (normal_n > (1 + options_.most_shear_sensed) * most_n_) {
    if (!sensed.summed) return out;
    maps_.add(skin_->without_pull(maps_), normal_n);
    most_n_ = normal_n;
    if (!read_sensed(patch, normal_n, sensed)) return out;
  }
  const double values = skin_->values();
  if (sensed.summed) {
    const auto shears = static_cast<double>(2 * layout_.size());
    const double noise_pa2 = skin_->shear_pa2(), excess_pa2 = sensed.sum.excess_pa2();
    give_moments(sensed.sum,
                 {.excess_pa2 = excess_pa2,
                  .noise_pa2 = noise_pa2 * std::sqrt(2 * SubsurfacePressureMaps::kOfMeasuredNoise * shears),
                  .explained_pa2 = skin_->shear_square_pa2() - shears * noise_pa2 - excess_pa2},
                 out);
  }
  const std::size_t step = sensed.best;
  if (step == kSteps) return out;
  const Trial best = trials_[step];
  const SubsurfacePressureMaps::Pull pull = skin_->pull(step);
  const std::size_t closest = closest_trial();  // whatever the prior says
  if (skin_->history_gain(closest, skin_->pull(closest)) > kStandsOutSigmas * kStandsOutSigmas) return out;
  const double residual_pa2 = trials_[closest].residual_pa2;
  conclude(patch, best,
           {.excess_pa2 = residual_pa2 - skin_->shear_pa2() * values,
            .noise_pa2 = best.noise_pa2 * std::sqrt(2 * SubsurfacePressureMaps::kOfMeasuredNoise * values),
            .explained_pa2 = skin_->square_pa2() - residual_pa2},
           out);
  if (!out.in_model) return out;
  out.normal_n = normal_n;
  out.shear_n = norm(pull.x, pull.y) * (1 - best.gamma) * normal_n;
  const double by_depth = sigma_by_depth(patch, step, out.gamma);
  out.sigma = norm(out.sigma, by_depth);
  out.common_sigma = norm(out.common_sigma, by_depth);
  out.friction_sigma = norm(out.friction_sigma, out.friction * by_depth / (1 - out.gamma));
  return out;
}

}  // namespace slipd
