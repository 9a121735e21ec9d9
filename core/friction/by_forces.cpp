#include "core/friction/by_forces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/frame/significance.hpp"
#include "core/health/usual.hpp"
#include "core/load/load_path.hpp"

namespace slipd {
namespace {

double square(double x) noexcept {
  return x * x;
}

FrictionFilterOptions with_rate(FrictionFilterOptions options) noexcept {
  options.posterior.falls_per_s = options.posterior.rises_per_s = options.force_only_changes_per_s;
  return options;
}

}  // namespace

FrictionByForces::FrictionByForces(const FrictionPrior& prior, const FrictionFilterOptions& options)
    : FrictionFilter(prior, options.force_only_points(), with_rate(options)) {}

void FrictionByForces::reset() noexcept {
  reset_evidence();
  grasp_ = {};
}

void FrictionByForces::update(const FrictionFrame& frame) noexcept {
  const ContactPatch& patch = frame.patch;
  begin_frame(frame);
  forget_lighter(patch);
  watch_hook();
  const bool self_stressed =
      grasp_.exceeds_friction || frame.previous.field.internal_share > kMaxInternalShare;
  if (!self_stressed) bound_by_held();
  if (frame.reading != nullptr && patch.shear_n > kStrongSigmas * patch.shear_sigma_n)
    weigh_frame(patch, *frame.reading);
  if (const auto slide = traction_ratio_.detect_slide(frame.previous); slide && !self_stressed)
    weigh_slide(*slide);
  posterior_.conclude();
}

void FrictionByForces::forget_lighter(const ContactPatch& patch) noexcept {
  if (patch.normal_n <= kGrown * grasp_.lighter_n) return;
  if (grasp_.lighter_n > 0) posterior_.may_have_changed(1 - 1 / kGrown);
  grasp_.lighter_n = patch.normal_n;
}

// More than the greatest expected friction holds: something hooks. What the load showed of friction while it
// rose to that is forgotten.
void FrictionByForces::watch_hook() noexcept {
  const MeanSigma load = traction_ratio_.held();
  const double highest = grid().friction(grid().count() - 1), lowest = grid().friction(0);
  if (load.mean - kClearSigmas * load.sigma > kBeyondUsual * highest) grasp_.exceeds_friction = true;
  if (!grasp_.exceeds_friction) return;
  posterior_.reset();
  grasp_.exceeds_friction = load.mean > lowest;
}

// Of few taxels: a frame says something of its margin while the load is the highest of the grasp.
void FrictionByForces::weigh_frame(const ContactPatch& patch, const Reading& reading) noexcept {
  history_.classify(
      traction_ratio_.is_highest(patch.shear_n / patch.normal_n, patch.shear_sigma_n / patch.normal_n));
  if (!is_monotonic(history()) || !reading.in_model) return;
  // Of the mean load, as FrictionByShape::compare_margin() says.
  const double load = traction_ratio_.now().mean;
  if (reading.profile.known) {
    weigh_profile(reading.profile, load);
    explain(0, reading.sigma < options_.confirming_sigma);
    return;
  }
  PerFriction residuals;  // the first grid().count() of them
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < grid().count(); ++j) {
    residuals[j] = reading.gamma - std::max(0.0, 1 - load / grid().friction(j));
    least = std::min(least, square(residuals[j] / reading.sigma));
  }
  explain(least, reading.sigma < options_.confirming_sigma);
  weigh_margin(residuals, reading, 0, std::min(1.0, load / likeliest()));
}

// Coulomb: friction is the |Q|/P of a slide, whose roughness is the same from frame to frame.
void FrictionByForces::weigh_slide(const TractionRatioFilter::Slide& slide) noexcept {
  PerFriction residuals;  // the first grid().count() of them
  for (std::size_t j = 0; j < grid().count(); ++j) residuals[j] = std::log(slide.load / grid().friction(j));
  posterior_.weigh(Evidence::slide, residuals, slide.sigma, slide.sigma);
}

}  // namespace slipd
