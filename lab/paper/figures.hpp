// The paper's figures 3 and 4 as CSV and SVG.
#pragma once

#include <filesystem>

#include "lab/paper/protocol.hpp"

namespace lab {

// Writes figure3.csv, figure3.svg, figure4.csv and figure4.svg into the folder, which it creates. `row`: the
// results shown.
void write_figures(const std::filesystem::path& folder, const Row& row);

}  // namespace lab
