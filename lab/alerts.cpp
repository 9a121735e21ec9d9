// `slipd-lab alerts`: how many holds have an alert and how many slips have one in time, on the simulated
// presets.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <iterator>
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
  std::vector<double> costs{slipd::AlertSettings{}.cost};
  std::size_t grasps = 1000;
  unsigned threads = 2;
  bool each_pillar = false;
};

// Of each grasp, at each cost.
using Trials = std::vector<std::vector<AlertTrialPair>>;

Trials run_kind(const PresetBench& bench, GraspKind kind, const AlertsOptions& options, std::uint64_t seed) {
  offline::ProgressBar bar(std::string(to_string(bench.preset)) +
                           (kind == GraspKind::hold ? " holds" : " slips"));
  return collect(
      options.grasps, options.threads, [&](double share) { bar.show(share, "grasps"); },
      [&](std::size_t i) {
        return run_preset_grasp(bench, draw_preset_grasp(bench, kind, seed, i), options.costs);
      });
}

std::vector<AlertTrial> of_chain(const Trials& trials, std::size_t cost, bool known) {
  std::vector<AlertTrial> chosen;
  chosen.reserve(trials.size());
  for (const auto& grasp : trials) chosen.push_back(known ? grasp[cost].known : grasp[cost].unknown);
  return chosen;
}

void run_alerts(const offline::Common& common, const AlertsOptions& options) {
  std::vector<AlertLine> lines;
  for (const std::string& name : options.presets) {
    PresetBench bench = bench_of(slipd::sim::preset_of(name).value());
    if (options.each_pillar) bench.skin.base = slipd::SkinBase::pillars;
    const auto holds = run_kind(bench, GraspKind::hold, options, common.seed);
    const auto slips = run_kind(bench, GraspKind::slip, options, common.seed);
    for (const bool known : {true, false})
      for (std::size_t i = 0; i < options.costs.size(); ++i)
        lines.push_back(count_alerts(bench, known, options.costs[i], of_chain(holds, i, known),
                                     of_chain(slips, i, known)));
  }
  const bool one = options.costs.size() == 1;
  std::vector<AlertLine> at_default;
  std::ranges::copy_if(lines, std::back_inserter(at_default),
                       [](const AlertLine& line) { return line.cost == slipd::AlertSettings{}.cost; });
  publish(
      {.print_table =
           [&] {
             std::cout << (one ? alerts_table(lines) : alerts_table(at_default) + "\n" + costs_table(lines));
           },
       .json = [&] { return to_sweep(lines); },
       .write_files =
           [&](const std::filesystem::path& folder) {
             if (!one) plot_costs(lines, folder);
           }},
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
  command->add_flag("--each-pillar", options->each_pillar,
                    "read what each taxel carries, as with skin.base pillars");
  command
      ->add_option(
          "--costs", options->costs,
          "of a slip that is not told, in needless alerts: alerts.cost; several, in a list: also a table "
          "and a plot of what each chooses")
      ->delimiter(',')
      ->check(CLI::Range(1.0, 1e5))
      ->capture_default_str();
  command->callback([&common, options] { run_alerts(common, *options); });
}

}  // namespace lab
