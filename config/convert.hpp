// Checked JSON → Settings, and the checks that no schema can say. Inside of settings.cpp, apart for size.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "config/schema.hpp"
#include "config/settings.hpp"

namespace slipd {

// Whether any of `problems` lies at `pointer`, below it, or above it (what lies in a list that is too long
// was not looked at).
bool is_touched(const std::vector<Problem>& problems, const std::string& pointer);

// `root` is an object that check() has seen, with `problems` found; sections among which there is one are
// left out of the result, the others are converted and checked further, so that all problems come out at
// once.
Settings convert(const nlohmann::json& root, std::vector<Problem>& problems);

}  // namespace slipd
