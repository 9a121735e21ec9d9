#include "core/patch/contact_gate.hpp"

#include <algorithm>
#include <cmath>

#include "core/frame/few_taxels.hpp"
#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

constexpr double kFewTaxelsMinNormalN = 0.1;

bool is_small(const TaxelLayout& layout) noexcept {
  return layout.size() <= kFewTaxels;
}

}  // namespace

double default_min_normal_n(const TaxelLayout& layout) noexcept {
  return is_small(layout) ? kFewTaxelsMinNormalN : 0;
}

bool ContactGate::judge(const Frame& /*frame*/, const ContactPatch& patch) noexcept {
  const double least_n = std::max(min_normal_n_, kStandsOutSigmas * normal_noise_n());
  touching_ = patch.in_contact && patch.normal_n >= (touching_ ? options_.kept_share : 1) * least_n;
  return touching_;
}

FewTaxelsGate::FewTaxelsGate(const TaxelLayout& layout, SensorClass sensor_class, double min_normal_n,
                             const ContactGateOptions& options)
    : ContactGate(min_normal_n, options),
      area_m2_(layout.area_m2()),
      shows_shear_(sensor_class != SensorClass::normal),
      unloaded_n_(std::max(min_normal_n, kFewTaxelsMinNormalN)),
      noise_(layout, unloaded_n_) {}

double FewTaxelsGate::normal_noise_n() const noexcept {
  return noise_.now() ? noise_.now()->normal_n : 0;
}

double FewTaxelsGate::pull_threshold_n() const noexcept {
  const double noise_n = noise_.now() ? noise_.now()->shear_n : 0;
  return std::max(kShearOverNormal * unloaded_n_, kStandsOutSigmas * noise_n);
}

bool FewTaxelsGate::judge(const Frame& frame, const ContactPatch& patch) noexcept {
  const bool touches = ContactGate::judge(frame, patch);
  pulled_.reset();
  const PulledForces all = forces_on(frame);
  if (!touches && shows_shear_ && all.shear_n > pull_threshold_n()) pulled_ = all;
  if (first_ && pulled_) zero_is_anothers_ = true;
  if (!touches && !pulled_) zero_is_anothers_ = false;
  first_ = false;
  noise_.update(frame);
  return touches;
}

PulledForces FewTaxelsGate::forces_on(const Frame& frame) const noexcept {
  double p = 0, x = 0, y = 0;
  for (std::size_t i = 0; i < frame.normal_pa.size(); ++i) {
    p += static_cast<double>(frame.normal_pa[i]);
    x += static_cast<double>(frame.shear_x_pa[i]);
    y += static_cast<double>(frame.shear_y_pa[i]);
  }
  return {p * area_m2_, norm(x, y) * area_m2_};
}

std::unique_ptr<ContactGate> make_contact_gate(const TaxelLayout& layout, SensorClass sensor_class,
                                               std::optional<double> min_normal_n,
                                               const ContactGateOptions& options) {
  const double least_n = min_normal_n.value_or(default_min_normal_n(layout));
  if (is_small(layout)) return std::make_unique<FewTaxelsGate>(layout, sensor_class, least_n, options);
  return std::make_unique<ContactGate>(least_n, options);
}

}  // namespace slipd
