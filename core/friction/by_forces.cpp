#include "core/friction/by_forces.hpp"

namespace slipd {
namespace {

constexpr double kSecondsPerNs = 1e-9;

}  // namespace

FrictionByForces::FrictionByForces(const FrictionPrior& prior, const FrictionFilterOptions& options)
    : FrictionFilter(prior, options.force_only_points, options), traction_ratio_(options.traction_ratio) {}

void FrictionByForces::reset() noexcept {
  reset_evidence();
  traction_ratio_.reset();
  grasp_ = {};
}

void FrictionByForces::update(const FrictionFrame& frame) noexcept {
  const ContactPatch& patch = frame.patch;
  traction_ratio_.update(patch);
  frame_ = {.traction_ratio = traction_ratio_.now()};
  fade(frame.time_ns);
  forget_lighter(patch);
  watch_hook();
  const bool self_stressed =
      grasp_.exceeds_friction || frame.previous.field.internal_share > options_.max_internal_share;
  if (!self_stressed) {
    const auto [load, frames] = traction_ratio_.held();
    bound_below(load, frames);
  }
  if (frame.reading != nullptr && patch.shear_n > options_.min_shear_sigmas * patch.shear_sigma_n)
    weigh_frame(patch, *frame.reading);
  if (const auto slide = traction_ratio_.detect_slide(frame.previous); slide && !self_stressed)
    weigh_slide(*slide);
  grid_.normalise();
}

// Evidence of forces alone grows old.
void FrictionByForces::fade(std::int64_t time_ns) noexcept {
  const double passed_s =
      grasp_.last_ns > 0 ? static_cast<double>(time_ns - grasp_.last_ns) * kSecondsPerNs : 0;
  grasp_.last_ns = time_ns;
  grid_.fade(std::exp(-std::max(0.0, passed_s) / options_.forget_s));
}

void FrictionByForces::forget_lighter(const ContactPatch& patch) noexcept {
  if (patch.normal_n <= options_.grown * grasp_.lighter_n) return;
  if (grasp_.lighter_n > 0) grid_.fade(options_.kept_when_grown);
  grasp_.lighter_n = patch.normal_n;
}

// More than the greatest expected friction holds: something hooks. What the load showed of friction while it
// rose to that is forgotten.
void FrictionByForces::watch_hook() noexcept {
  const MeanSigma load = traction_ratio_.held().load;
  const double highest = grid_.friction(grid_.count() - 1), lowest = grid_.friction(0);
  if (load.mean - options_.exceeds_friction_sigmas * load.sigma > options_.exceeds_friction * highest)
    grasp_.exceeds_friction = true;
  if (!grasp_.exceeds_friction) return;
  grid_.reset();
  grasp_.exceeds_friction = load.mean > lowest;
}

// Of few taxels: a frame says something of its margin while the load is the highest of the grasp.
void FrictionByForces::weigh_frame(const ContactPatch& patch, const Reading& reading) noexcept {
  const double load = patch.shear_n / patch.normal_n;
  history_.classify(traction_ratio_.is_highest(load, patch.shear_sigma_n / patch.normal_n));
  if (!is_monotonic(history()) || !reading.in_model) return;
  PerFriction residuals;  // the first grid_.count() of them
  for (std::size_t j = 0; j < grid_.count(); ++j) residuals[j] = margin_residual(j, load, reading, {});
  evidence_.discount.add(reading.sigma / options_.alike_sigma);
  part_errors(patch);
  take_evidence(residuals, reading.sigma < options_.confirming_sigma, share_of_margin(load, reading));
}

// Coulomb: friction is the |Q|/P of a slide.
void FrictionByForces::weigh_slide(const TractionRatioFilter::Slide& slide) noexcept {
  for (std::size_t j = 0; j < grid_.count(); ++j) {
    const double off = std::log(grid_.friction(j) / slide.load) / slide.sigma;
    grid_.take(j, options_.frame_share * 0.5 * std::min(off * off, options_.max_slide_residual));
  }
}

}  // namespace slipd
