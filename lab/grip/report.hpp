// What many trials say together, as a table.
#pragma once

#include <iosfwd>
#include <nlohmann/json.hpp>
#include <vector>

#include "lab/grip/trial.hpp"

namespace lab::grip {

struct GripSummary {
  std::size_t tasks = 0;
  // Objects lost, and those that moved more than 5 mm: listening, and deaf with the same mean force.
  std::size_t dropped = 0, moved = 0, deaf_dropped = 0, deaf_moved = 0;
  // Against both true margins.
  struct Against {
    // Force over the least that holds, median over the probes: all, and those at which slipd knew the margin.
    double force_over_least = 0, force_over_least_known = 0;
    // slipd's margin less the true one: mean of the absolute error, and the share of probes where slipd's is
    // safer by 0.2; of gamma_low the share above the truth.
    double margin_error = 0, too_safe_share = 0, low_above_truth_share = 0;
  };
  Against sliding, turning;
  std::size_t probes = 0, known_probes = 0;
  // Slides in the holds: those that were answered by more force, after how many frames (median, 99th
  // percentile), and those that were not.
  std::size_t answered_slides = 0, unanswered_slides = 0;
  double reaction_median_frames = 0, reaction_p99_frames = 0;
  // Of the frames of all holds.
  double known_share = 0;
};

// `deaf`: of the same tasks, in the same order.
GripSummary summarise(const std::vector<TrialResult>& listening, const std::vector<TrialResult>& deaf);

void print_table(const GripSummary& summary, double creep_mm_per_min);
nlohmann::json to_json(const GripSummary& summary, double creep_mm_per_min);

}  // namespace lab::grip
