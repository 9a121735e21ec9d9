// `slipd-lab alerts`: how many holds have an alert and how many slips have one in time, on the simulated
// presets.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "lab/alerts/report.hpp"
#include "lab/collect.hpp"
#include "lab/command.hpp"
#include "lab/options.hpp"
#include "tools/offline/progress.hpp"

namespace lab {
namespace {

struct AlertsOptions {
  std::vector<std::string> presets{"pillars", "magnetic-skin"};
  std::size_t grasps = 1000;
  unsigned threads = 2;
};

std::vector<AlertTrialPair> run_kind(const PresetBench& bench, GraspKind kind, const AlertsOptions& options,
                                     std::uint64_t seed) {
  offline::ProgressBar bar(std::string(to_string(bench.preset)) +
                           (kind == GraspKind::hold ? " holds" : " slips"));
  return collect(
      options.grasps, options.threads, [&](double share) { bar.show(share, "grasps"); },
      [&](std::size_t i) { return run_preset_grasp(bench, draw_preset_grasp(bench, kind, seed, i)); });
}

std::vector<AlertTrial> of_chain(const std::vector<AlertTrialPair>& pairs, bool known) {
  std::vector<AlertTrial> trials;
  trials.reserve(pairs.size());
  for (const AlertTrialPair& pair : pairs) trials.push_back(known ? pair.known : pair.unknown);
  return trials;
}

void run_alerts(const offline::Common& common, const AlertsOptions& options) {
  std::vector<AlertLine> lines;
  for (const std::string& name : options.presets) {
    const PresetBench bench = bench_of(slipd::sim::preset_of(name).value());
    const auto holds = run_kind(bench, GraspKind::hold, options, common.seed);
    const auto slips = run_kind(bench, GraspKind::slip, options, common.seed);
    for (const bool known : {true, false})
      lines.push_back(count_alerts(bench, known, of_chain(holds, known), of_chain(slips, known)));
  }
  publish({.print_table = [&] { std::cout << alerts_table(lines); }, .json = [&] { return to_sweep(lines); }},
          common);
}

}  // namespace

void add_alerts(CLI::App& app, const offline::Common& common) {
  auto* command = app.add_subcommand("alerts", "alerts in holds and slips on the simulated presets");
  auto options = std::make_shared<AlertsOptions>();
  add_presets_option(*command, options->presets, {"ideal", "pillars", "magnetic-skin"},
                     "ideal, pillars, magnetic-skin");
  add_grasps_option(*command, options->grasps, "holds, and as many slips, of each preset");
  add_threads_option(*command, options->threads);
  command->callback([&common, options] { run_alerts(common, *options); });
}

}  // namespace lab
