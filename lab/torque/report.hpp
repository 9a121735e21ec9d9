// Tables, files and the plot of `slipd-lab torque`.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "lab/torque/measure.hpp"

namespace lab {

void print_table(const std::vector<TorqueLine>& lines, const TorqueSetup& setup);
nlohmann::ordered_json to_json(const std::vector<TorqueLine>& lines, const TorqueSetup& setup);
// torque.csv, torque.dat, torque.gp, torque.svg.
void write_files(const std::vector<TorqueLine>& lines, const std::filesystem::path& folder);

}  // namespace lab
