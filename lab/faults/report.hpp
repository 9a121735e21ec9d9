// What `slipd-lab faults` measured, as a table of docs/reliability.md and as JSON.
#pragma once

#include <vector>

#include "lab/faults/measure.hpp"
#include "lab/report.hpp"

namespace lab {

// A Markdown table on standard output, one line for each fault, layout and method.
void print_table(const std::vector<FaultLine>& lines, const FaultSetup& setup);
offline::SweepResult to_sweep(const std::vector<FaultLine>& lines, const FaultSetup& setup);

}  // namespace lab
