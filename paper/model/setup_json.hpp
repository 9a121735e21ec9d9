// A model's setup as JSON: its form in the model file, and what its name is the hash of.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "paper/model/model.hpp"

namespace slipd {

nlohmann::json to_json(const ModelSetup& setup);

// Throws nlohmann::json::exception or std::invalid_argument for anything else than what to_json gives.
ModelSetup setup_of(const nlohmann::json& from);

}  // namespace slipd
