// The work-precision results as a table, JSON and a plot.
#pragma once

#include <filesystem>
#include <vector>

#include "lab/tradeoff/measure.hpp"

namespace lab {

void print_table(const std::vector<Line>& lines, std::size_t contacts);
offline::SweepResult to_sweep(const std::vector<Line>& lines, std::size_t contacts);
void write_files(const std::vector<Line>& lines, std::size_t contacts, const std::filesystem::path& folder);

}  // namespace lab
