// What each kind of fit.hpp compares with the contact model, and how it finds the minimum.
#include <memory>

#include "core/frame/few_taxels.hpp"
#include "core/reading/fit/fit.hpp"

namespace slipd {

void FewTaxelsFit::read(const ContactPatch& patch, const MomentRatio& ratio, Reading& out) noexcept {
  const auto first = start_of(patch, ratio);
  if (!first) return;
  const Minimum minimum = minimise(*first);
  weigh_by_prior(minimum.at, parabola(minimum).profile_share(), out);
  place(patch, minimum.at, out);
  out.in_model = minimum.converged && !patch.cut;
}

ArrayFit::ArrayFit(const TaxelLayout& layout, Range friction_expected, const FitOptions& options,
                   FitSamples& samples)
    : Fit(layout, friction_expected, options, samples), ellipses_(layout, friction_expected, 0, options) {}

void ArrayFit::read(const ContactPatch& patch, const MomentRatio& ratio, Reading& out) noexcept {
  if (ratio.deviation.ellipticity > options_.elliptic_from) {
    out = ellipses_.estimate(patch, ratio);
  } else if (const auto first = start_of(patch, ratio)) {
    conclude(patch, ratio, find_minimum(patch, *first), out);
  }
}

Fit::Minimum TaxelFit::find_minimum(const ContactPatch& /*patch*/, const Vector& start) noexcept {
  return minimise(start);
}

BlockFit::BlockFit(const TaxelLayout& layout, Range friction_expected, const FitOptions& options)
    : BlockFit(layout, friction_expected, options,
               std::make_unique<BlockSamples>(layout, options.blocks_along_radius)) {}

bool BlockFit::fits(const TaxelLayout& layout) noexcept {
  return layout.size() > kFewTaxels && SquareBlocks::fits(layout);
}

void BlockFit::collect(const ContactPatch& patch) noexcept {
  blocks_->collect(patch, options_.first_blocks_along_radius);
}

Fit::Minimum BlockFit::find_minimum(const ContactPatch& patch, const Vector& start) noexcept {
  Minimum best = minimise(start);
  blocks_->collect(patch, options_.blocks_along_radius);
  set_noise(patch);
  if (best.converged && take_last_step(best)) return best;
  return minimise(best.converged ? best.at : start);
}

// --- under a skin

FitUnderSkin::FitUnderSkin(const TaxelLayout& layout, Range friction_expected, const Skin& skin,
                           const FitOptions& options)
    : layout_(layout),
      ratio_(options.ratio),
      fit_(make_subsurface_fit(layout, friction_expected, skin, options)) {}

Reading FitUnderSkin::estimate(const Frame& /*frame*/, const ContactPatch& patch) noexcept {
  return fit_->estimate(patch, moment_ratio(patch, layout_, ratio_));
}

std::unique_ptr<SlipMethod> make_fit(const TaxelLayout& layout, Range friction_expected, const Skin& skin,
                                     const FitOptions& options) {
  if (skin.depth_m > 0) return std::make_unique<FitUnderSkin>(layout, friction_expected, skin, options);
  if (layout.size() <= kFewTaxels) return std::make_unique<FewTaxelsFit>(layout, friction_expected, options);
  if (options.blocks_along_radius > 0 && BlockFit::fits(layout))
    return std::make_unique<BlockFit>(layout, friction_expected, options);
  return std::make_unique<TaxelFit>(layout, friction_expected, options);
}

}  // namespace slipd
