// The results of `slipd-lab stability` as tables, JSON and plots.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "lab/stability/condition.hpp"
#include "lab/stability/extremes.hpp"
#include "lab/stability/trials.hpp"
#include "tools/offline/sweep.hpp"

namespace lab {

enum StabilityPart : std::size_t { model_part, extremes_part, condition_part, adversary_part, torque_part };
inline constexpr std::array<const char*, 5> kStabilityParts{"model", "extremes", "condition", "adversary",
                                                            "torque"};

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
// Its units are its parts, in the order of kStabilityParts.
offline::SweepResult to_sweep(const Stability& found, const offline::Shard& shard);

// Writes CSV files and, with enough rows, plots.
void write_files(const Stability& found, const std::filesystem::path& folder);

}  // namespace lab
