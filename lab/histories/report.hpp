// What `slipd-lab histories` measured, as a table, as JSON, as CSV and as a plot.
#pragma once

#include <filesystem>
#include <vector>

#include "lab/histories/measure.hpp"
#include "lab/report.hpp"

namespace lab {

void print_table(const std::vector<HistoriesLine>& lines, const HistoriesSetup& setup);
offline::SweepResult to_sweep(const std::vector<HistoriesLine>& lines, const HistoriesSetup& setup);
// histories.csv, histories.svg, and the first grasp of each line.
void write_files(const std::vector<HistoriesLine>& lines, const std::filesystem::path& folder);

}  // namespace lab
