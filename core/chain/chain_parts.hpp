// Makes the parts of a sensor's chain from its set-up. Set-up only; any thread.
#pragma once

#include <memory>
#include <string>

#include "core/chain/setup/setup.hpp"
#include "core/health/limits.hpp"
#include "core/margin/margin_source.hpp"
#include "core/margin/surface_load.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/method/trained_model.hpp"
#include "core/reading/method/work_precision.hpp"

namespace slipd {

// `setup` with the skin as it counts (sensed_depth_m).
ChainSetup with_sensed_skin(const ChainSetup& setup);

// Given for the sensor, else what its scene expects.
KnownFriction known_friction(const ChainSetup& setup);

// Why the configured method cannot read these taxels under their skin, for people; empty: it can.
std::string why_method_cannot_read(const ChainSetup& setup);

// The method of single frames of a curved skin. Sets `work_precision` to what the choice was made by, or to
// that of the model. Throws std::invalid_argument if the method needs a model of this layout and there is
// none, or with why_method_cannot_read.
std::unique_ptr<SlipMethod> make_method(const ChainSetup& setup,
                                        const std::shared_ptr<const TrainedModel>& model,
                                        WorkPrecision& work_precision);

// What turns measured forces into those that act at the surface of a curved skin.
std::unique_ptr<SurfaceForces> make_surface_forces(const ChainSetup& setup);

// Where margins come from. common_sigma: of SurfaceForces.
std::unique_ptr<MarginSource> make_margin_source(const ChainSetup& setup, double common_sigma);

// Flat skins keep the hollows of flat objects; elsewhere neighbours stand for dead taxels.
PatchOptions patch_options(const ChainSetup& setup);

// Bounds of a^3/P = 3 R/(4 E*) over the contacts that the scene expects; for the stiffest one against the
// sharpest object, for the softest one against the flattest.
PlausibilityLimits plausibility_limits(const ChainSetup& setup);

}  // namespace slipd
