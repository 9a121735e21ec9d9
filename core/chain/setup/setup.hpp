// What a sensor's chain is made from, and which method that asks for. Set-up only; any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "core/contact/scene.hpp"
#include "core/estimate/settings.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/health/limits.hpp"

namespace slipd {

struct ChainSetup {
  TaxelLayout layout;
  SensorClass sensor_class = SensorClass::array3;
  Scene scene;
  EstimatorSettings estimator;
  AlertSettings alerts;
  std::optional<KnownFriction> friction;  // known beforehand
  // Of the sensor, as configured; none: that of its class.
  std::optional<FullScale> full_scale = std::nullopt;
  ContactSettings contact = {};
  bool operator==(const ChainSetup&) const = default;
};

// Whether the chain uses `fit` whatever method is configured: with tracking and at most kFewTaxels
// taxels, whose margin no single frame determines; fit reads the whole pad for what FrictionFilter weighs
// over time.
bool fits_whole_pad(const ChainSetup& setup);

// Why a sensor's method is the one that it is.
enum class MethodReason : std::uint8_t {
  configured,  // estimator.method names it
  automatic,   // `auto` chose it by error and time on the sensor's scene
  few_taxels,  // see fits_whole_pad
  skin,        // `auto`, under a skin of known depth: only fit and closing correct for it
  forces,      // without taxels and curvature, friction and forces give the margin
  no_shear,    // there is no margin
  no_force     // there is no margin: displacements are no forces
};
std::string_view to_string(MethodReason reason) noexcept;  // as on the socket: "configured", "auto", …
MethodReason why_method(const ChainSetup& setup);

// Whether a trained model is needed, so that a scene that needs none never makes one.
bool needs_model(const ChainSetup& setup);

}  // namespace slipd
