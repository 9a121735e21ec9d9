// Makes the parts of a sensor's chain from its setup: the method, and the options and limits of the other
// parts. Set-up only; any thread.
#pragma once

#include <memory>
#include <optional>

#include "core/chain/chain.hpp"
#include "core/friction/pad_load_sharing.hpp"
#include "core/health/limits.hpp"
#include "core/margin/margin_fusion.hpp"
#include "core/margin/pad_forces.hpp"
#include "core/reading/method/method.hpp"
#include "core/reading/method/trained_model.hpp"
#include "core/reading/method/work_precision.hpp"

namespace slipd {

// One force vector, or a skin without the curvature that makes a contact Hertzian.
bool only_forces(const ChainSetup& setup);

// Friction is weighed over a grasp's frames because no single one determines it.
bool weighed_over_time(const ChainSetup& setup);

// Of few taxels with a method of their own under a skin; else none.
std::optional<PadForces> make_pad_forces(const ChainSetup& setup);

// On few taxels a contact reaches beyond the pad, or falls between them: their sums miss traction that is
// locked in after an unloading. `pad_forces`: of few taxels under a skin; null: none.
MarginFusionOptions tracker_options(const ChainSetup& setup, const PadForces* pad_forces);

// `setup`, without a skin if that is thinner than a ninth of a taxel's side: a taxel's average of what is
// felt through it would take hundreds of points, and is within some per cent what is felt without it. Margins
// by forces alone need no contact model, so that a skin has no effect on them.
ChainSetup with_felt_skin(const ChainSetup& setup);

// The method of single frames; null where only forces are measured. Sets `work_precision` to what was
// measured for the choice, or to that of the model. Throws std::invalid_argument if the method needs a model
// of this layout and there is none, or if it cannot read taxels under a skin.
std::unique_ptr<SlipMethod> make_method(const ChainSetup& setup,
                                        const std::shared_ptr<const TrainedModel>& model,
                                        WorkPrecision& work_precision);

// For `auto`, method closing for frames that its method refuses; null for other choices, and where closing
// cannot be used.
std::unique_ptr<SlipMethod> make_closing_beside(const ChainSetup& setup);

// Flat skins keep the hollows of flat objects; elsewhere neighbours stand for dead taxels.
PatchOptions patch_options(const ChainSetup& setup);

// For a flat skin whose friction is not known to a value; null for other sensors, and with too few or too
// many taxels.
std::unique_ptr<PadLoadSharing> make_shared_shear(const ChainSetup& setup);

// Bounds of a^3/P = 3 R/(4 E*) over the contacts that the scene expects; for the stiffest one against the
// sharpest object, for the softest one against the flattest.
PlausibilityLimits plausibility_limits(const ChainSetup& setup);

}  // namespace slipd
