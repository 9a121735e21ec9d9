// `slipd-lab faults`: what slipd says of random grasps whose sensor breaks in mid-grasp.
#include <CLI/CLI.hpp>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lab/command.hpp"
#include "lab/faults/report.hpp"
#include "lab/noise_options.hpp"
#include "paper/model_setup.hpp"
#include "paper/train.hpp"
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

const std::map<std::string, MethodChoice> kFaultsMethods{
    {"svd-knn", MethodChoice::svd_knn},     {"registered", MethodChoice::registered},
    {"moments", MethodChoice::moments},     {"fit", MethodChoice::fit},
    {"block-fit", MethodChoice::block_fit}, {"auto", MethodChoice::automatic}};

// The method that this layout gets, by its name on the command line. `auto` compares methods by their speed:
// that is done once, not for each grasp.
std::string used_method(const ChainSetup& chain) {
  if (needs_model(chain)) return "";  // as asked for
  return std::string(to_string(EstimatorChain(chain, nullptr).method()));
}

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
void measure_layout(std::size_t side, std::string name, const FaultsOptions& options,
                    std::vector<FaultLine>& lines) {
  ChainSetup chain = paper_chain(side, kFaultsMethods.at(name), options.setup.sensing.noise);
  if (const std::string used = used_method(chain); !used.empty() && used != name) {
    name = used;
    chain.estimator.method = kFaultsMethods.at(name);
  }
  for (const FaultLine& line : lines) {
    if (line.columns == side && line.method == name) return;
  }
  offline::ProgressBar bar(std::to_string(side) + "x" + std::to_string(side) + " " + name);
  std::shared_ptr<const Model> model;
  if (needs_model(chain)) {
    bar.show(0, "training");
    model = std::make_shared<const Model>(train(model_setup_of(chain), options.setup.threads));
  }
  for (FaultLine& line : measure_faults(chain, model, chosen(options), options.setup,
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
  if (common.json) {
    std::cout << to_json(lines, options.setup).dump(2) << '\n';
  } else {
    print_table(lines, options.setup);
  }
}

}  // namespace

void add_faults(CLI::App& app, const offline::Common& common) {
  auto* command = app.add_subcommand("faults", "random grasps whose sensor breaks in mid-grasp");
  auto options = std::make_shared<FaultsOptions>();
  options->setup.sensing.frame_s = 0.001;
  command->add_option("--grasps", options->setup.grasps, "of each line")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--sides", options->sides, "taxels along each side of the pad")
      ->delimiter(',')
      ->check(CLI::Range(2, 200))
      ->capture_default_str();
  command->add_option("--methods", options->methods, "moments, fit, auto, registered, svd-knn")
      ->delimiter(',')
      ->check(CLI::IsMember(kFaultsMethods))
      ->capture_default_str();
  command->add_option("--faults", options->faults, "all if none is named")
      ->delimiter(',')
      ->check(CLI::IsMember(faults_by_name()));
  command
      ->add_option("--presets", options->presets, "grasps of simulated real sensors in place of ideal ones")
      ->delimiter(',')
      ->check(CLI::IsMember({"pillars", "magnetic-skin"}));
  add_noise_options(*command, options->setup.sensing.noise, options->setup.sensing.kind);
  command->add_option("--frame-s", options->setup.sensing.frame_s, "between frames of the sensor")
      ->check(CLI::Range(1e-4, 0.1))
      ->capture_default_str();
  command->add_option("--threads", options->setup.threads)->check(CLI::Range(1, 4))->capture_default_str();
  command->callback([&common, options] { run_faults(common, *options); });
}

}  // namespace lab
