#include "drivers/sim/simulated_sensor.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/contact/averages.hpp"

namespace slipd::sim {
namespace {
constexpr double kStrongestGripN = 1000;

bool is_ideal(const SensorSettings& settings) {
  return settings.preset == Preset::ideal;
}

// The pair of bodies of the ideal contact; of any other, one that is not used.
contact::BodyPair body_pair_of(const SensorSettings& settings) {
  return is_ideal(settings) ? contact::make_body_pair(settings.skin, settings.object)
                            : contact::make_body_pair(SensorSettings{}.skin, SensorSettings{}.object);
}

std::unique_ptr<RealisticSensor> realistic_of(const TaxelLayout& layout, const SensorSettings& settings) {
  auto effects = effects_of(settings.preset);
  if (!effects) return nullptr;
  if (layout.size() == 1) throw std::invalid_argument("preset: one force vector has preset ideal only");
  if (effects->depth_m > 0 && settings.imprint.depth_m > 0) effects->depth_m = settings.imprint.depth_m;
  RoughContactSettings& contact = effects->contact;
  contact.modulus_pa = settings.skin.modulus_pa;
  contact.curvature_per_m = 1 / settings.skin.radius_m + 1 / settings.object.radius_m;
  contact.apex_x_m = settings.offset_x_m;
  contact.apex_y_m = settings.offset_y_m;
  return std::make_unique<RealisticSensor>(*effects, layout, settings.imperfections.seed);
}

std::unique_ptr<contact::TurningContact> turning_of(const TaxelLayout& layout,
                                                    const SensorSettings& settings) {
  if (!turns(settings)) return nullptr;
  if (!is_ideal(settings) || layout.size() == 1)
    throw std::invalid_argument("torque: needs preset ideal and several taxels");
  return std::make_unique<contact::TurningContact>(body_pair_of(settings));
}

std::unique_ptr<contact::ContactField> geometry_of(const TaxelLayout& layout,
                                                   const SensorSettings& settings) {
  if (settings.imprint.plain() || !is_ideal(settings) || layout.size() == 1) return nullptr;
  return std::make_unique<contact::ContactField>(layout, settings.imprint);
}

}  // namespace

bool turns(const SensorSettings& settings) noexcept {
  return settings.lever_m != 0 || std::any_of(settings.cycle.begin(), settings.cycle.end(),
                                              [](const Phase& phase) { return phase.torque_nm.has_value(); });
}

SimulatedSensor::SimulatedSensor(TaxelLayout layout, const SensorSettings& settings)
    : layout_(std::move(layout)),
      one_vector_(layout_.size() == 1),
      offset_x_m_(settings.offset_x_m),
      offset_y_m_(settings.offset_y_m),
      lever_m_(settings.lever_m),
      script_(settings.cycle),
      load_(body_pair_of(settings)),
      turning_(turning_of(layout_, settings)),
      hertz_(settings.lever_m == 0 ? nullptr
                                   : std::make_unique<contact::LimitSurface>(contact::unit_hertz_surface())),
      imprint_(geometry_of(layout_, settings)),
      realistic_(realistic_of(layout_, settings)),
      imperfections_(settings.imperfections, layout_.size()),
      normal_pa_(layout_.size()),
      shear_pa_(layout_.size()),
      across_pa_(turning_ || imprint_ ? layout_.size() : 0) {
  if (!realistic_) script_.walk(0, 0, [this](const LoadTarget& target) { apply_target(target); });
}

void SimulatedSensor::advance(std::chrono::nanoseconds by) noexcept {
  const std::int64_t from_ns =
      std::exchange(elapsed_ns_, elapsed_ns_ + std::max<std::int64_t>(0, by.count()));
  if (realistic_) return advance_realistic(from_ns);
  script_.walk(from_ns, elapsed_ns_, [this](const LoadTarget& target) { apply_target(target); });
}

void SimulatedSensor::advance_realistic(std::int64_t from_ns) noexcept {
  while (from_ns < elapsed_ns_) {
    const std::int64_t to_ns = std::min(elapsed_ns_, from_ns + RealisticSensor::kLongestStepNs);
    LoadTarget target;
    script_.walk(from_ns, to_ns, [&target](const LoadTarget& last) { target = last; });
    if (grip_n_) target.normal_n = *grip_n_;
    realistic_->update(target, to_ns);
    from_ns = to_ns;
  }
}

void SimulatedSensor::grip(std::optional<double> normal_n) noexcept {
  if (normal_n) normal_n = std::isnan(*normal_n) ? 0 : std::clamp(*normal_n, 0.0, kStrongestGripN);
  grip_n_ = normal_n;
}

void SimulatedSensor::apply_target(const LoadTarget& target) noexcept {
  const double normal_n = grip_n_.value_or(target.normal_n);
  const double was_normal_n = load_.normal_n(), was_shear_n = load_.shear_n(),
               was_friction = load_.friction();
  double shear_n = target.shear_n(normal_n);
  if (target.by_load && lever_m_ != 0) shear_n /= lever_share(normal_n);
  if (turning_) apply_turning(normal_n, shear_n, target);
  // Throws only for invalid forces or friction, which neither the checked script nor grip() lets through.
  load_.move_to(normal_n, shear_n, target.friction);
  moved_ = moved_ || load_.normal_n() != was_normal_n || load_.shear_n() != was_shear_n ||
           load_.friction() != was_friction;
}

double SimulatedSensor::lever_share(double normal_n) const noexcept {
  if (!(normal_n > 0)) return 1;
  return hertz_->least_friction(1, 0, lever_m_ / load_.pair().contact_radius_m(normal_n)).ratio;
}

// From the first torque of a contact on, its tractions are those of a contact that turns.
void SimulatedSensor::apply_turning(double normal_n, double shear_n, const LoadTarget& target) noexcept {
  const contact::PlaneLoad load{
      .shear_x_n = shear_n, .shear_y_n = 0, .torque_nm = target.torque_nm + lever_m_ * shear_n};
  if (!(normal_n > 0)) return turning_->release();
  if (!turning_->active()) {
    if (load.torque_nm == 0) return;
    if (!(load_.normal_n() > 0)) load_.move_to(normal_n, 0, target.friction);
    turning_->begin(load_);
  } else if (normal_n == turning_->normal_n() && target.friction == turning_->friction() &&
             load == turning_->load()) {
    return;
  }
  turning_->move_to(normal_n, load, target.friction);
  moved_ = true;
}

void SimulatedSensor::compute_taxels() noexcept {
  if (!std::exchange(moved_, false)) return;
  if (turning_ && turning_->active()) {
    turning_->taxel_averages(layout_, offset_x_m_, offset_y_m_, normal_pa_, shear_pa_, across_pa_);
    return;
  }
  if (imprint_) {
    imprint_->sense(load_, offset_x_m_, offset_y_m_, 0, normal_pa_, shear_pa_, across_pa_);
    return;
  }
  std::fill(across_pa_.begin(), across_pa_.end(), 0.0F);
  if (one_vector_) {
    normal_pa_[0] = static_cast<float>(load_.normal_n() / layout_.area_m2());
    shear_pa_[0] = static_cast<float>(load_.shear_n() / layout_.area_m2());
    return;
  }
  contact::taxel_averages(layout_, offset_x_m_, offset_y_m_, load_, normal_pa_, shear_pa_);
}

bool SimulatedSensor::sample(FrameSlot& out) noexcept {
  const std::uint64_t number = number_++;
  if (imperfections_.lost(number)) return false;
  if (!realistic_) compute_taxels();
  out.sequence = number;
  out.time_ns = elapsed_ns_;
  out.device_time_ns = elapsed_ns_;
  out.truth = truth();
  if (realistic_) {
    realistic_->sense(out, number, elapsed_ns_);
  } else {
    std::copy(normal_pa_.begin(), normal_pa_.end(), out.normal_pa.begin());
    std::copy(shear_pa_.begin(), shear_pa_.end(), out.shear_x_pa.begin());
    if (!across_pa_.empty())
      std::copy(across_pa_.begin(), across_pa_.end(), out.shear_y_pa.begin());
    else
      std::fill(out.shear_y_pa.begin(), out.shear_y_pa.end(), 0.0F);
  }
  imperfections_.apply(out, number, 1e-9 * static_cast<double>(elapsed_ns_));
  if (realistic_) realistic_->limit(out);
  return true;
}

Truth SimulatedSensor::truth() const noexcept {
  if (realistic_) return realistic_->truth();
  if (load_.normal_n() == 0) return {};
  if (turning_ && turning_->active()) return {turning_->safety_margin(), turning_->friction()};
  return {load_.safety_margin(), load_.friction()};
}

}  // namespace slipd::sim
