#include "core/chain/shaped_pipelines.hpp"

#include <utility>

#include "core/advice/alert.hpp"
#include "core/chain/chain_parts.hpp"
#include "core/frame/few_taxels.hpp"
#include "core/frame/significance.hpp"

namespace slipd {
namespace {

bool is_clear(const ContactPatch& patch) noexcept {
  return patch.shear_n > kClearSigmas * patch.shear_sigma_n;
}

std::unique_ptr<TorqueReading> make_torque_reading(const ChainSetup& setup) {
  if (setup.estimator.tracking) return std::make_unique<TorqueReadingOverTime>(setup.layout);
  return std::make_unique<TorqueReadingOfFrames>(setup.layout);
}

}  // namespace

ShapedPipeline::ShapedPipeline(const ChainSetup& setup, std::unique_ptr<SlipMethod> method)
    : ShapedPipeline(setup, std::move(method), make_surface_forces(setup)) {}

ShapedPipeline::ShapedPipeline(const ChainSetup& setup, std::unique_ptr<SlipMethod> method,
                               std::unique_ptr<SurfaceForces> forces)
    : ShearPipeline(setup, forces->common_sigma()), method_(std::move(method)), forces_(std::move(forces)) {}

void ShapedPipeline::estimate(const Frame& frame, const ContactPatch& patch, const SlidingVerdict& previous,
                              MarginDecision& decision, Estimate& out) noexcept {
  method_->observe(frame, patch);
  publish_forces(patch, out);
  publish_place(patch, out);
  publish_torque(patch, out);
  const EquivalentPullResult pull = pull_of(patch);
  out.pull_n = pull.pull_n;
  const ContactPatch pulled = with_pull(patch, pull);
  const std::optional<Reading> reading = read(frame, patch, pulled, pull);
  const SurfaceLoad load = forces_->of(patch, pulled, reading.value_or(Reading{}), out);
  const bool under_torque = reading && reading->under_torque;
  margin().estimate({.measured = patch,
                     .step = follow(load_of(out.time_ns, patch, load.acting, under_torque)),
                     .acting = load.acting,
                     .reading = reading ? &*reading : nullptr,
                     .previous_sliding = previous},
                    decision, out);
  if (!load.known && decision.stands()) {
    decision.refuse(State::out_of_model);
    out.friction.reset();
    out.friction_sigma.reset();
  }
  if (reading && reading->in_model && !reading->under_torque) {
    out.center_x_m = reading->center_x_m;
    out.center_y_m = reading->center_y_m;
    out.radius_m = reading->radius_m;
  }
  conclude(load, 0, pull, decision, out);
}

Reading ShapedPipeline::read_pull(const Frame& frame, const ContactPatch& patch) noexcept {
  Reading reading = method_->estimate(frame, patch);
  if (reading.by == Method::none) reading.by = method_->name();
  return reading;
}

void ShapedPipeline::forget() noexcept {
  ShearPipeline::forget();
  method_->forget();
  forces_->forget();
}

ArrayPipeline::ArrayPipeline(const ChainSetup& setup, std::unique_ptr<SlipMethod> method)
    : ShapedPipeline(setup, std::move(method)), torque_reading_(make_torque_reading(setup)) {}

std::optional<Reading> ArrayPipeline::read(const Frame& frame, const ContactPatch& patch,
                                           const ContactPatch& pulled,
                                           const EquivalentPullResult& pull) noexcept {
  torque_reading_->follow(patch, pull, margin().friction());
  if (patch.count < kFewInside || !(pull.torque_effect == TorqueEffect::changes_shear || is_clear(patch)))
    return std::nullopt;
  if (!torque_reading_->torque_changes_shear(pull)) return read_pull(frame, patch);
  Reading reading = torque_reading_->estimate(pulled, pull);
  reading.by = method();
  return reading;
}

std::vector<std::string_view> ArrayPipeline::stages() const {
  std::vector<std::string_view> all = ShapedPipeline::stages();
  all.insert(all.begin() + 2, "torque_reading");
  return all;
}

void ArrayPipeline::forget() noexcept {
  ShapedPipeline::forget();
  torque_reading_->forget();
}

void ArrayPipeline::lose_sight() noexcept {
  ShapedPipeline::lose_sight();
  torque_reading_->lose_sight();
}

FewTaxelsPipeline::FewTaxelsPipeline(const ChainSetup& setup, std::unique_ptr<SlipMethod> method)
    : ShapedPipeline(setup, std::move(method)) {}

std::optional<Reading> FewTaxelsPipeline::read(const Frame& frame, const ContactPatch& patch,
                                               const ContactPatch& /*pulled*/,
                                               const EquivalentPullResult& pull) noexcept {
  if (pull.torque_effect == TorqueEffect::changes_shear || !is_clear(patch)) return std::nullopt;
  return read_pull(frame, patch);
}

}  // namespace slipd
