// What `slipd-lab faults` measured, as a table of docs/reliability.md and as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "lab/faults/measure.hpp"

namespace lab {

// A Markdown table on standard output, one line for each fault, layout and method.
void print_table(const std::vector<FaultLine>& lines, const FaultSetup& setup);
nlohmann::ordered_json to_json(const std::vector<FaultLine>& lines, const FaultSetup& setup);

}  // namespace lab
