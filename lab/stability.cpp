// `slipd-lab stability`: the limits of the arithmetic and of the estimators. The contact model at extreme
// parameters against many digits, the condition of the methods, and contacts that deviate from the model.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "lab/command.hpp"
#include "lab/options.hpp"
#include "lab/report.hpp"
#include "lab/stability/report.hpp"
#include "lab/stability/turning_trials.hpp"
#include "tools/offline/parallel.hpp"
#include "tools/offline/progress.hpp"

namespace lab {
namespace {

struct StabilityOptions {
  TrialSetup setup;
  std::vector<std::string> parts{kStabilityParts.begin(), kStabilityParts.end()};
  offline::Shard shard;  // of the parts
};

std::vector<ContactModelError> worst_everywhere(const TrialSetup& setup, const Done& done) {
  std::vector<ContactModelError> rows;
  for (const Axis axis : kAxes) {
    for (const double place : places_on(axis)) rows.push_back({axis, place, 0, 0, 0, 0, 0});
  }
  offline::for_each_index(
      rows.size(), setup.threads,
      [&](std::size_t i) {
        rows[i] = model_error_at(rows[i].axis, rows[i].place, setup.contacts, setup.seed);
      },
      done);
  return rows;
}

void run(const offline::Common& common, const CLI::App& command, StabilityOptions options) {
  offline::refuse_files(options.shard, common);
  options.setup.seed = common.seed;
  const auto wanted = [&](StabilityPart part) {
    return options.shard.has(part) && std::find(options.parts.begin(), options.parts.end(),
                                                kStabilityParts.at(part)) != options.parts.end();
  };
  Stability found;
  found.setup = options.setup;
  {
    offline::ProgressBar bar("stability");
    double from = 0;
    const auto part = [&](const char* what) {
      return
          [&bar, what, from, to = from + 0.2](double share) { bar.show(from + share * (to - from), what); };
    };
    if (wanted(model_part)) found.model = worst_everywhere(found.setup, part("model"));
    from = 0.2;
    if (wanted(extremes_part)) found.extremes = measure_extremes(found.setup, part("extremes"));
    from = 0.4;
    if (wanted(condition_part)) {
      bar.show(from, "training");
      auto methods = all_methods(found.setup);
      for (const auto& method : methods) found.methods.push_back(method.name);
      found.condition = condition_of(found.setup, methods, part("condition"));
      found.bits = bits_needed(found.setup, methods, part("bits"));
    }
    from = 0.6;
    if (wanted(adversary_part)) found.perturbations = measure_perturbations(found.setup, part("adversary"));
    from = 0.8;
    if (wanted(torque_part)) found.turning = measure_turning(found.setup, part("torque"));
  }
  publish({.print_table = [&] { print_table(found); },
           .json = [&] { return to_sweep(found, options.shard); },
           .write_files = [&](const auto& folder) { write_files(found, folder); }},
          common, options.shard, command);
}

}  // namespace

void add_stability(CLI::App& app, const offline::Common& common) {
  auto* command = app.add_subcommand(
      "stability",
      "measure extreme contacts, the effect of errors in a frame, and contacts unlike the model");
  auto options = std::make_shared<StabilityOptions>();
  command
      ->add_option("--parts", options->parts,
                   "parts to run, out of model, extremes, condition, adversary, torque; default: all")
      ->delimiter(',')
      ->check(CLI::IsMember(kStabilityParts));
  command->add_option("--side", options->setup.side, "taxels along each side of the pad")
      ->check(CLI::Range(8, 100))
      ->capture_default_str();
  command->add_option("--contacts", options->setup.contacts, "contacts for each row of the result")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  add_noise_options(*command, options->setup.noise, options->setup.kind);
  add_threads_option(*command, options->setup.threads);
  offline::add_shard_option(*command, options->shard);
  command->callback([&common, command, options] { run(common, *command, *options); });
}

}  // namespace lab
