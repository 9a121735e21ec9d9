#include "core/reading/pressure_maps/maps_beside_method.hpp"

#include <cmath>
#include <utility>

#include "core/frame/model_errors.hpp"
#include "core/reading/moments/moments.hpp"

namespace slipd {
namespace {

bool knows_moments(const Reading& reading) noexcept {
  return std::isfinite(reading.moments_sigma.slip_moment_n);
}

}  // namespace

void MapsBesideMethod::observe(const Frame& frame, const ContactPatch& patch) noexcept {
  method_->observe(frame, patch);
  maps_->observe(frame, patch);
}

void MapsBesideMethod::forget() noexcept {
  method_->forget();
  maps_->forget();
}

Reading MapsBesideMethod::read_by_method(const Frame& frame, const ContactPatch& patch) noexcept {
  Reading reading = method_->estimate(frame, patch);
  reading.by = method_->name();
  return reading;
}

Reading MapsBesideMethod::read_by_maps(const Frame& frame, const ContactPatch& patch) noexcept {
  Reading reading = maps_->estimate(frame, patch);
  reading.by = maps_->name();
  return reading;
}

Reading MapsBesideMethod::take_maps(Reading by_maps, const Reading& by_method) noexcept {
  if (!knows_moments(by_maps)) by_maps.take_moments(by_method);
  return by_maps;
}

Reading MapsBesideMethod::take_method(const Reading& by_maps, Reading by_method) noexcept {
  if (knows_moments(by_maps)) by_method.take_moments(by_maps);
  return by_method;
}

Reading MapsAtSurface::estimate(const Frame& frame, const ContactPatch& patch) noexcept {
  const Reading by_method = read_by_method(frame, patch);
  if (by_method.in_model && by_method.common_sigma < kModelSigma) return by_method;
  if (moment_ratio(patch, layout_).deviation.sigma() < kModelSigma) return by_method;
  const Reading by_maps = read_by_maps(frame, patch);
  const bool better = by_maps.in_model && !(by_method.in_model && by_method.sigma < by_maps.sigma);
  return better ? take_maps(by_maps, by_method) : take_method(by_maps, by_method);
}

Reading MapsUnderSkin::estimate(const Frame& frame, const ContactPatch& patch) noexcept {
  const Reading by_method = read_by_method(frame, patch);
  if (by_method.shape_sigma < kModelSigma) return by_method;
  const Reading by_maps = read_by_maps(frame, patch);
  return by_maps.in_model ? take_maps(by_maps, by_method) : take_method(by_maps, by_method);
}

}  // namespace slipd
