// The table of `slipd-lab gels`.
#pragma once

#include <vector>

#include "lab/gels/measure.hpp"
#include "lab/report.hpp"

namespace lab {

void print_table(const std::vector<GelLine>& lines, const GelSetup& setup);
offline::SweepResult to_sweep(const std::vector<GelLine>& lines, const GelSetup& setup);

}  // namespace lab
