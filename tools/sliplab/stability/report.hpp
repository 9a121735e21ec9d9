// The results of `sliplab stability` as tables, JSON and plots.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/sliplab/stability/condition.hpp"
#include "tools/sliplab/stability/extremes.hpp"
#include "tools/sliplab/stability/trials.hpp"

namespace sliplab {

// A part that was not requested is empty.
struct Stability {
  TrialSetup setup;
  std::vector<ContactModelError> model;      // of the contact model
  std::vector<RobustnessRow> extremes;       // of the estimators at extreme parameters
  std::vector<std::string> methods;          // of `condition` and `bits`
  std::vector<Condition> condition;          // for each margin
  std::vector<Bits> bits;                    // for each number of significant bits
  std::vector<RobustnessRow> perturbations;  // of the contact model
  std::vector<RobustnessRow> turning;        // under force and torque
};

void print_table(const Stability& found);
nlohmann::ordered_json to_json(const Stability& found);

// Writes CSV files and, with enough rows, plots.
void write_files(const Stability& found, const std::filesystem::path& folder);

}  // namespace sliplab
