// What `sliplab stability` found, for people, for programs and as plots.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/sliplab/stability/condition.hpp"
#include "tools/sliplab/stability/extremes.hpp"
#include "tools/sliplab/stability/trials.hpp"

namespace sliplab {

// A part that was not asked for is empty.
struct Stability {
  TrialSetup setup;
  std::vector<Worst> model;
  std::vector<Ordeal> extremes;
  std::vector<std::string> methods;  // of the two below
  std::vector<Condition> condition;
  std::vector<Bits> bits;
  std::vector<Ordeal> flaws;
};

void print_table(const Stability& found);
nlohmann::ordered_json to_json(const Stability& found);

// CSV files and, where there are enough rows to see anything, plots.
void write_files(const Stability& found, const std::filesystem::path& folder);

}  // namespace sliplab
