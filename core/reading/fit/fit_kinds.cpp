// What each kind of fit.hpp compares with the contact model: all taxels, those inside the contact, square
// blocks of them, or taxels under a skin.
#include <algorithm>
#include <memory>
#include <utility>

#include "core/frame/few_taxels.hpp"
#include "core/reading/fit/fit.hpp"

namespace slipd {

// --- taxels by themselves

TaxelFit::TaxelFit(const TaxelLayout& layout, Range friction_expected, const FitOptions& options)
    : Fit(layout, friction_expected, options, layout.size()), sheet_(layout.size(), layout.side_m()) {}

void TaxelFit::take(const ContactPatch& patch, std::uint32_t taxel) noexcept {
  x_[frame_.count] = layout_.x_m()[taxel] - patch.center_x_m;
  y_[frame_.count] = layout_.y_m()[taxel] - patch.center_y_m;
  p_[frame_.count] = patch.taxels.normal_pa[taxel];
  q_[frame_.count] = patch.shear_along_pa(taxel);
  ++frame_.count;
}

void TaxelFit::fill_sheet(double x, const Vector& /*at*/, Sheet& out) noexcept {
  sheet_.evaluate(x, {u_.data(), frame_.count}, {v_.data(), frame_.count}, {out.value.data(), frame_.count},
                  {out.d_x.data(), frame_.count}, {out.d_u.data(), frame_.count},
                  {out.d_v.data(), frame_.count});
}

void FewTaxelsFit::collect(const ContactPatch& patch) noexcept {
  for (std::uint32_t i = 0; i < layout_.size(); ++i) take(patch, i);
  set_noise(patch);
}

void FewTaxelsFit::read(const ContactPatch& patch, const MomentRatio& ratio, Reading& out) noexcept {
  const auto first = start_of(patch, ratio);
  if (!first) return;
  const Minimum minimum = minimise(*first, options_.converged_sigmas);
  Vector gradient;
  Square hessian;
  evaluate(minimum.at, gradient, hessian);
  weigh_by_prior(minimum.at, hessian, out);
  place(patch, minimum.at, out);
  out.in_model = minimum.converged;
}

ArrayFit::ArrayFit(const TaxelLayout& layout, Range friction_expected, const FitOptions& options)
    : TaxelFit(layout, friction_expected, options), ellipses_(layout, friction_expected, 0, options) {}

void ArrayFit::collect(const ContactPatch& patch) noexcept {
  patch.for_each_inside([&](std::uint32_t i) { take(patch, i); });
  set_noise(patch);
}

void ArrayFit::read(const ContactPatch& patch, const MomentRatio& ratio, Reading& out) noexcept {
  if (ratio.deviation.ellipticity > options_.elliptic_from) {
    out = ellipses_.estimate(patch, ratio);
  } else if (const auto first = start_of(patch, ratio)) {
    conclude(patch, ratio, minimise(*first, options_.converged_sigmas), out);
  }
}

// --- square blocks

BlockFit::BlockFit(const TaxelLayout& layout, Range friction_expected, const FitOptions& options)
    : BlockFit(SquareBlocks(layout, options.blocks_along_radius), layout, friction_expected, options) {}

BlockFit::BlockFit(SquareBlocks blocks, const TaxelLayout& layout, Range friction_expected,
                   const FitOptions& options)
    : Fit(layout, friction_expected, options, blocks.most_along() * blocks.most_along()),
      blocks_(std::move(blocks)),
      lattice_(blocks_.most_along()),
      ellipses_(layout, friction_expected, 0, options) {}

bool BlockFit::fits(const TaxelLayout& layout) noexcept {
  return layout.size() > kFewTaxels && SquareBlocks::fits(layout);
}

std::size_t BlockFit::memory_bytes() const noexcept {
  return sizeof(*this) + list_bytes() + blocks_.memory_bytes() + lattice_.memory_bytes() +
         ellipses_.memory_bytes();
}

void BlockFit::collect(const ContactPatch& patch) noexcept {
  collect(patch, options_.first_blocks_along_radius);
}

void BlockFit::collect(const ContactPatch& patch, double along_radius) noexcept {
  blocks_.sum(patch, along_radius);
  lattice_.set({.left_m = blocks_.left_m(),
                .bottom_m = blocks_.bottom_m(),
                .side_m = blocks_.side_m(),
                .rows = blocks_.rows()});
  frame_.count = blocks_.size();
  std::copy_n(blocks_.x_m().begin(), frame_.count, x_.begin());
  std::copy_n(blocks_.y_m().begin(), frame_.count, y_.begin());
  std::copy_n(blocks_.normal_pa().begin(), frame_.count, p_.begin());
  std::copy_n(blocks_.shear_pa().begin(), frame_.count, q_.begin());
  set_noise(patch, static_cast<double>(blocks_.taxels_along()));
}

void BlockFit::fill_sheet(double x, const Vector& at, Sheet& out) noexcept {
  lattice_.evaluate(x, at[center_x], at[center_y], {out.value.data(), frame_.count},
                    {out.d_x.data(), frame_.count}, {out.d_u.data(), frame_.count},
                    {out.d_v.data(), frame_.count});
}

Fit::Minimum BlockFit::find_minimum(const ContactPatch& patch, const Vector& start) noexcept {
  Minimum best = minimise(start, options_.first_converged_sigmas);
  collect(patch, options_.blocks_along_radius);
  if (best.converged && take_last_step(best)) return best;
  return minimise(best.converged ? best.at : start, options_.converged_sigmas);
}

void BlockFit::read(const ContactPatch& patch, const MomentRatio& ratio, Reading& out) noexcept {
  if (ratio.deviation.ellipticity > options_.elliptic_from) {
    out = ellipses_.estimate(patch, ratio);
  } else if (const auto first = start_of(patch, ratio)) {
    conclude(patch, ratio, find_minimum(patch, *first), out);
  }
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
  return std::make_unique<ArrayFit>(layout, friction_expected, options);
}

}  // namespace slipd
