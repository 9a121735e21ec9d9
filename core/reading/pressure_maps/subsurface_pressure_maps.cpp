#include "core/reading/pressure_maps/subsurface_pressure_maps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/health/usual.hpp"
#include "core/load/load_path.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

// Taxels of the maps that are filtered in one frame while the gripper closes; for an estimate least_maps
// times as many; 1000 … 100000, at least one map. Too few: after a quick grip, margins come late. Too many:
// single frames take long.
constexpr std::size_t kFilteredInClosing = 4096;

}  // namespace

SubsurfacePressureMaps::SubsurfacePressureMaps(const TaxelLayout& layout, Range friction_expected,
                                               const Skin& skin, const SubsurfacePressureMapsOptions& options)
    : layout_(layout),
      options_(options),
      maps_(layout.size(), true),
      sensed_(layout, skin, MarginTrials::kSteps),
      trials_({.expected = friction_expected, .spread = options.maps.prior.scene_spread}) {}

void SubsurfacePressureMaps::forget() noexcept {
  maps_.clear();
  sensed_.forget();
  most_n_ = pulled_n_ = 0;
  asked_at_gamma_ = std::numeric_limits<double>::infinity();
}

double SubsurfacePressureMaps::force_n(const ContactPatch& patch) const noexcept {
  double sum_pa = 0;
  for (std::size_t i = 0; i < layout_.size(); ++i) sum_pa += patch.taxels.normal_pa[i];
  return layout_.area_m2() * sum_pa;
}

bool SubsurfacePressureMaps::recorded(double normal_n) const noexcept {
  return maps_.size() >= options_.maps.least_maps && maps_.force_n(0) <= normal_n / kGrown &&
         normal_n <= options_.maps.most_step * most_n_;
}

// Only while the force rises: the first of a pull in a held grip would be taken for what pressing is sensed
// as.
void SubsurfacePressureMaps::observe(const Frame&, const ContactPatch& patch) noexcept {
  if (!(patch.normal_n > 0) || patch.normal_n < kStandsOutSigmas * patch.normal_sigma_n) return;
  const double normal_n = force_n(patch);
  if (patch.shear_n > kPulled * patch.normal_n && patch.shear_n > kStandsOutSigmas * patch.shear_sigma_n)
    pulled_n_ = std::max(pulled_n_, normal_n);
  if (!(normal_n > 0) || normal_n < kGrown * pulled_n_) return;
  const bool pulled = patch.shear_n > options_.most_shear_sensed * patch.normal_n &&
                      patch.shear_n > kClearSigmas * patch.shear_sigma_n;
  if (pulled) return;
  if (normal_n > most_n_ && maps_.frames_like(normal_n) < learning_frames())
    maps_.add(patch.taxels, normal_n);
  most_n_ = std::max(most_n_, normal_n);
  sensed_.prepare(maps_, kFilteredInClosing, maps_.slot_of(normal_n));
}

MarginTrial SubsurfacePressureMaps::judge(std::size_t step, const ContactPatch& patch) const noexcept {
  const SensedMaps::Pull pull = sensed_.pull(step);
  MarginTrial trial{.gamma = MarginTrials::gamma_of(step)};
  if (!(pull.noise_pa2 > 0)) return trial;
  trial.residual_pa2 = pull.residual_pa2;
  trial.noise_pa2 = pull.noise_pa2;
  trial.misfit = 0.5 * trial.residual_pa2 / trial.noise_pa2;
  // Both maps' noise is the same in all frames: the difference's, and that of what pressing is sensed as.
  trial.map_share = std::min(1.0, pull.map_share + sensed_.pressing_share());
  // Against the force: noise.
  const double along = pull.x * patch.direction_x + pull.y * patch.direction_y;
  trials_.weigh_friction(along > 0 ? norm(pull.x, pull.y) : along, pull.square_pa2, trial);
  return trial;
}

// The maps are the same ones for all margins. So their noise is taken off each residual, and does not speak
// against margins that need more friction.
std::optional<std::size_t> SubsurfacePressureMaps::judge(const ContactPatch& patch) noexcept {
  for (std::size_t i = 0; i < MarginTrials::kSteps; ++i) trials_[i] = judge(i, patch);
  const std::optional<std::size_t> best = trials_.best();
  if (!best) return best;
  const double noise_pa2 = trials_[*best].noise_pa2;
  for (MarginTrial& trial : trials_) trial.misfit = 0.5 * trial.residual_pa2 / noise_pa2;
  return best;
}

std::optional<SubsurfacePressureMaps::SensedFrame> SubsurfacePressureMaps::read(const ContactPatch& patch,
                                                                                double normal_n) noexcept {
  sensed_.prepare(maps_, options_.maps.least_maps * kFilteredInClosing);
  if (!sensed_.ready(maps_)) return std::nullopt;
  sensed_.read(patch.taxels, maps_, normal_n);
  SensedFrame out{.best = judge(patch), .sum = JaegerDecomposition(normal_n)};
  out.summed = sensed_.superpose(maps_, normal_n, patch.direction_x, patch.direction_y, out.sum);
  const double unlike = out.summed ? sensed_.unlike_superposed(maps_, patch.direction_x, patch.direction_y)
                        : out.best ? sensed_.unlike(maps_, *out.best, sensed_.pull(*out.best))
                                   : std::numeric_limits<double>::infinity();
  if (!(unlike < kUnlike)) return std::nullopt;
  return out;
}

std::optional<SubsurfacePressureMaps::SensedFrame> SubsurfacePressureMaps::read_grown(
    const ContactPatch& patch, double normal_n, const SensedFrame& before) noexcept {
  if (!before.summed) return std::nullopt;
  maps_.add(sensed_.without_pull(maps_), normal_n);
  most_n_ = normal_n;
  return read(patch, normal_n);
}

void SubsurfacePressureMaps::give_moments(const JaegerDecomposition& sum, Reading& out) const noexcept {
  const auto shears = static_cast<double>(2 * layout_.size());
  const double noise_pa2 = sensed_.shear_pa2(), excess_pa2 = sum.excess_pa2();
  const ShearSquares squares{.excess_pa2 = excess_pa2,
                             .noise_pa2 = noise_pa2 * std::sqrt(2 * SensedMaps::kOfMeasuredNoise * shears),
                             .explained_pa2 = sensed_.shear_square_pa2() - shears * noise_pa2 - excess_pa2};
  if (squares.unexplained_share() > kMostUnexplained) return;
  sum.give_moments(out);
  if (!(sum.shear_n() > 0)) return;
  out.normal_n = sum.normal_n();
  out.shear_n = sum.shear_n();
}

// The same frame, read as if the taxels lay deeper.
double SubsurfacePressureMaps::sigma_by_depth(const ContactPatch& patch, std::size_t best,
                                              double gamma) noexcept {
  if (!(std::fabs(gamma - asked_at_gamma_) > kModelSigma)) return by_depth_;
  sensed_.deepen(maps_, best, sensed_.pull(best));
  judge(patch);
  Reading deeper;
  trials_.weigh(deeper);
  asked_at_gamma_ = gamma;
  by_depth_ =
      deeper.in_model ? std::fabs(deeper.gamma - gamma) / SensedMaps::kDeeper * sensed_.depth_sigma() : 1;
  return by_depth_;
}

Reading SubsurfacePressureMaps::estimate(const Frame&, const ContactPatch& patch) noexcept {
  Reading out;
  const double normal_n = force_n(patch);
  if (!recorded(normal_n)) return out;
  std::optional<SensedFrame> frame = read(patch, normal_n);
  if (frame && normal_n > (1 + options_.most_shear_sensed) * most_n_)
    frame = read_grown(patch, normal_n, *frame);
  if (!frame) return out;
  if (frame->summed) give_moments(frame->sum, out);
  if (!frame->best) return out;
  const std::size_t step = *frame->best;
  const MarginTrial best = trials_[step];
  const SensedMaps::Pull pull = sensed_.pull(step);
  const std::optional<std::size_t> closest = trials_.closest();
  if (!closest ||
      sensed_.history_gain(*closest, sensed_.pull(*closest)) > kStandsOutSigmas * kStandsOutSigmas)
    return out;
  const double values = sensed_.values(), residual_pa2 = trials_[*closest].residual_pa2;
  const ShearSquares squares{
      .excess_pa2 = residual_pa2 - sensed_.shear_pa2() * values,
      .noise_pa2 = best.noise_pa2 * std::sqrt(2 * SensedMaps::kOfMeasuredNoise * values),
      .explained_pa2 = sensed_.square_pa2() - residual_pa2};
  const double unexplained = squares.unexplained_share();
  if (unexplained > kMostUnexplained) return out;
  trials_.weigh(out);
  conclude(patch, best, unexplained, out);
  out.normal_n = normal_n;
  out.shear_n = norm(pull.x, pull.y) * (1 - best.gamma) * normal_n;
  const double by_depth = sigma_by_depth(patch, step, out.gamma);
  out.sigma = norm(out.sigma, by_depth);
  out.common_sigma = norm(out.common_sigma, by_depth);
  out.friction_sigma = norm(out.friction_sigma, out.friction * by_depth / (1 - out.gamma));
  return out;
}

}  // namespace slipd
