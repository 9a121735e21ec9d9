// Frames of pressures or forces → estimates: patch, health, contact, a pipeline by the kind of sensor,
// margin, alerts.
#pragma once

#include <memory>

#include "core/chain/frame_chain.hpp"
#include "core/chain/setup/setup.hpp"
#include "core/reading/method/trained_model.hpp"

namespace slipd {

// Throws as EstimatorChain's constructor.
std::unique_ptr<FrameChain> make_pressure_chain(const ChainSetup& setup,
                                                const std::shared_ptr<const TrainedModel>& model);

}  // namespace slipd
