// `slipd-lab faults`: what slipd says of random grasps whose sensor breaks in mid-grasp.
#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lab/command.hpp"
#include "lab/faults/report.hpp"
#include "lab/options.hpp"
#include "tools/offline/progress.hpp"

namespace lab {
namespace {

using namespace slipd;

struct FaultsOptions {
  FaultSetup setup;
  std::vector<std::size_t> sides{4, 16, 100};
  std::vector<std::string> methods{"moments", "fit", "auto"};
  std::vector<std::string> faults;
  std::vector<std::string> presets;
};

std::map<std::string, Fault> faults_by_name() {
  std::map<std::string, Fault> all;
  for (std::size_t i = 1; i < kFaults; ++i) {
    const auto fault = static_cast<Fault>(i);
    all.emplace(name_of(fault), fault);
  }
  return all;
}

std::vector<Fault> chosen(const FaultsOptions& options) {
  std::vector<Fault> faults;
  if (options.faults.empty()) {
    for (std::size_t i = 1; i < kFaults; ++i) faults.push_back(static_cast<Fault>(i));
  }
  const auto known = faults_by_name();
  for (const auto& name : options.faults) faults.push_back(known.at(name));
  return faults;
}

// The lines of one layout and method; none where slipd takes a method for this layout that was measured.
// `auto` compares methods by their speed: that is done once, not for each grasp.
void measure_layout(std::size_t side, std::string name, const FaultsOptions& options,
                    std::vector<FaultLine>& lines) {
  offline::ProgressBar bar(title_of(side, name));
  bar.show(0, "training");
  Estimator estimator = make_estimator(
      paper_chain(side, method_choices().at(name), options.setup.sensing.noise), options.setup.threads);
  name = to_string(estimator.method());
  estimator.setup.estimator.method = method_choices().at(name);
  for (const FaultLine& line : lines) {
    if (line.columns == side && line.method == name) return;
  }
  for (FaultLine& line : measure_faults(estimator, chosen(options), options.setup,
                                        [&](double share) { bar.show(share, "grasps"); })) {
    line.columns = side;
    line.method = name;
    lines.push_back(std::move(line));
  }
}

void measure_preset(const std::string& name, const FaultsOptions& options, std::vector<FaultLine>& lines) {
  const PresetBench bench = bench_of(sim::preset_of(name).value());
  const ChainSetup chain = chain_of(bench, std::nullopt);
  offline::ProgressBar bar(name);
  for (FaultLine& line : measure_faults(bench, chain, chosen(options), options.setup,
                                        [&](double share) { bar.show(share, "grasps"); })) {
    line.preset = bench.preset;
    line.columns = bench.layout.regular()->columns;
    line.method = to_string(EstimatorChain(chain, nullptr).method());
    lines.push_back(std::move(line));
  }
}

void run_faults(const offline::Common& common, FaultsOptions options) {
  options.setup.seed = common.seed;
  std::vector<FaultLine> lines;
  for (const auto& preset : options.presets) measure_preset(preset, options, lines);
  if (!options.presets.empty()) options.sides.clear();
  for (const std::size_t side : options.sides) {
    for (const auto& method : options.methods) measure_layout(side, method, options, lines);
  }
  publish({.print_table = [&] { print_table(lines, options.setup); },
           .json = [&] { return to_sweep(lines, options.setup); }},
          common);
}

}  // namespace

void add_faults(CLI::App& app, const offline::Common& common) {
  auto* command = app.add_subcommand("faults", "random grasps whose sensor breaks in mid-grasp");
  auto options = std::make_shared<FaultsOptions>();
  options->setup.sensing.frame_s = 0.001;
  add_grasps_option(*command, options->setup.grasps);
  add_sides_option(*command, options->sides);
  add_methods_option(*command, options->methods);
  command->add_option("--faults", options->faults, "all if none is named")
      ->delimiter(',')
      ->check(CLI::IsMember(faults_by_name()));
  add_presets_option(*command, options->presets, {"pillars", "magnetic-skin"},
                     "grasps of simulated real sensors in place of ideal ones");
  add_noise_options(*command, options->setup.sensing.noise, options->setup.sensing.kind);
  add_frame_option(*command, options->setup.sensing.frame_s);
  add_threads_option(*command, options->setup.threads);
  command->callback([&common, options] { run_faults(common, *options); });
}

}  // namespace lab
