// Tables, files and the plot of `slipd-lab torque`.
#pragma once

#include <filesystem>
#include <vector>

#include "lab/report.hpp"
#include "lab/torque/measure.hpp"

namespace lab {

void print_table(const std::vector<TorqueLine>& lines, const TorqueSetup& setup);
offline::SweepResult to_sweep(const std::vector<TorqueLine>& lines, const TorqueSetup& setup);
// torque.csv, torque.dat, torque.gp, torque.svg.
void write_files(const std::vector<TorqueLine>& lines, const TorqueSetup& setup,
                 const std::filesystem::path& folder);

}  // namespace lab
