#include "lab/grip/report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace lab::grip {
namespace {

constexpr double kMovedM = 0.005, kTooSafe = 0.2;
// A true margin nearer to 1 has hardly a load: no force is the least for it.
constexpr double kMostMargin = 0.98;

// share: 0 … 1 of the values lie below it.
double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double median(const std::vector<double>& values) {
  return quantile(values, 0.5);
}

std::size_t count(const std::vector<TrialResult>& trials, bool (*is)(const TrialResult&)) {
  return static_cast<std::size_t>(std::count_if(trials.begin(), trials.end(), is));
}

double share(std::size_t part, std::size_t all) {
  return all == 0 ? std::nan("") : static_cast<double>(part) / static_cast<double>(all);
}

GripSummary::Against against(const std::vector<TrialResult>& trials, double TrueMargins::*which) {
  std::vector<double> forces, known_forces;
  double error = 0;
  std::size_t too_safe = 0, low_above = 0, lows = 0;
  for (const TrialResult& trial : trials) {
    for (const Probe& probe : trial.probes) {
      const double truth = probe.truth.*which;
      forces.push_back(1 / (1 - std::min(truth, kMostMargin)));
      if (probe.gamma_low) {
        ++lows;
        low_above += *probe.gamma_low > truth ? 1 : 0;
      }
      if (!probe.gamma) continue;
      known_forces.push_back(forces.back());
      error += std::abs(*probe.gamma - truth);
      too_safe += *probe.gamma > truth + kTooSafe ? 1 : 0;
    }
  }
  return {.force_over_least = median(forces),
          .force_over_least_known = median(known_forces),
          .margin_error = error / static_cast<double>(known_forces.size()),
          .too_safe_share = share(too_safe, known_forces.size()),
          .low_above_truth_share = share(low_above, lows)};
}

nlohmann::json to_json(const GripSummary::Against& against) {
  return {{"force_over_least", against.force_over_least},
          {"force_over_least_known", against.force_over_least_known},
          {"margin_error", against.margin_error},
          {"too_safe_share", against.too_safe_share},
          {"low_above_truth_share", against.low_above_truth_share}};
}

}  // namespace

GripSummary summarise(const std::vector<TrialResult>& listening, const std::vector<TrialResult>& deaf) {
  const auto is_dropped = [](const TrialResult& one) { return one.dropped; };
  const auto is_moved = [](const TrialResult& one) { return one.moved_m > kMovedM; };
  GripSummary sum{.tasks = listening.size(),
                  .dropped = count(listening, is_dropped),
                  .moved = count(listening, is_moved),
                  .deaf_dropped = count(deaf, is_dropped),
                  .deaf_moved = count(deaf, is_moved),
                  .sliding = against(listening, &TrueMargins::until_sliding),
                  .turning = against(listening, &TrueMargins::until_turning)};
  std::vector<double> reactions;
  for (const TrialResult& trial : listening) {
    sum.known_share += trial.known_share / static_cast<double>(listening.size());
    reactions.insert(reactions.end(), trial.reactions_frames.begin(), trial.reactions_frames.end());
    sum.unanswered_slides += static_cast<std::size_t>(trial.slides_unanswered);
    sum.probes += trial.probes.size();
    for (const Probe& probe : trial.probes) sum.known_probes += probe.gamma ? 1 : 0;
  }
  sum.answered_slides = reactions.size();
  sum.reaction_median_frames = median(reactions);
  sum.reaction_p99_frames = quantile(reactions, 0.99);
  return sum;
}

void print_table(const GripSummary& s, double creep_mm_per_min) {
  std::printf("| | %zu tasks |\n|---|---|\n", s.tasks);
  std::printf("| dropped, moved more than 5 mm, listening | %zu, %zu |\n", s.dropped, s.moved);
  std::printf("| the same, deaf, with the same mean force | %zu, %zu |\n", s.deaf_dropped, s.deaf_moved);
  std::printf("| frames of the holds, and probes, with a margin | %.0f %%, %zu of %zu |\n",
              100 * s.known_share, s.known_probes, s.probes);
  std::printf("| until the object: | slides; slides or turns |\n");
  std::printf("| force over the least that holds, median of all probes | %.2f; %.2f |\n",
              s.sliding.force_over_least, s.turning.force_over_least);
  std::printf("| the same, of those with a margin | %.2f; %.2f |\n", s.sliding.force_over_least_known,
              s.turning.force_over_least_known);
  std::printf("| margin against the true one: mean error | %.3f; %.3f |\n", s.sliding.margin_error,
              s.turning.margin_error);
  std::printf("| overestimates by more than 0.2 | %.1f; %.1f %% |\n", 100 * s.sliding.too_safe_share,
              100 * s.turning.too_safe_share);
  std::printf("| gamma_low above the true margin | %.1f; %.1f %% |\n", 100 * s.sliding.low_above_truth_share,
              100 * s.turning.low_above_truth_share);
  std::printf(
      "| slides in the holds that more force answers, after frames: median, p99; others, which end by "
      "themselves | %zu: %.0f, %.0f; %zu |\n",
      s.answered_slides, s.reaction_median_frames, s.reaction_p99_frames, s.unanswered_slides);
  std::printf("| MuJoCo's creep, at a margin of 0.5 | %.3f mm a minute |\n", creep_mm_per_min);
}

nlohmann::json to_json(const GripSummary& s, double creep_mm_per_min) {
  return {{"tasks", s.tasks},
          {"dropped", s.dropped},
          {"moved", s.moved},
          {"deaf_dropped", s.deaf_dropped},
          {"deaf_moved", s.deaf_moved},
          {"known_share", s.known_share},
          {"until_sliding", to_json(s.sliding)},
          {"until_turning", to_json(s.turning)},
          {"answered_slides", s.answered_slides},
          {"unanswered_slides", s.unanswered_slides},
          {"reaction_median_frames", s.reaction_median_frames},
          {"reaction_p99_frames", s.reaction_p99_frames},
          {"probes", s.probes},
          {"known_probes", s.known_probes},
          {"creep_mm_per_min", creep_mm_per_min}};
}

}  // namespace lab::grip
