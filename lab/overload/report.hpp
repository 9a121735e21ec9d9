// What `slipd-lab overload` measured, as a table, as JSON, as CSV and as a plot.
#pragma once

#include <filesystem>
#include <vector>

#include "lab/overload/measure.hpp"
#include "lab/report.hpp"

namespace lab {

void print_table(const std::vector<OverloadLine>& lines, const OverloadSetup& setup);
offline::SweepResult to_sweep(const std::vector<OverloadLine>& lines, const OverloadSetup& setup);

// overload.csv and overload.svg. Throws std::runtime_error where it cannot.
void write_files(const std::vector<OverloadLine>& lines, const OverloadSetup& setup,
                 const std::filesystem::path& folder);

}  // namespace lab
