// Which model a sensor's chain asks for: the one place where its name in the cache is decided, so that what
// one program trained another finds.
#pragma once

#include "core/chain/chain.hpp"
#include "paper/model/model.hpp"

namespace slipd {

// For a chain that needs_model.
ModelSetup model_setup_of(const ChainSetup& chain);

}  // namespace slipd
