// `slipd-lab torque`: margins and friction of contacts that carry force and torque, for each method and
// layout.
#include <CLI/CLI.hpp>
#include <memory>

#include "lab/command.hpp"
#include "lab/options.hpp"
#include "lab/torque/report.hpp"
#include "tools/offline/progress.hpp"

namespace lab {
namespace {

void run(const offline::Common& common, TorqueSetup setup) {
  setup.seed = common.seed;
  std::vector<TorqueLine> lines;
  {
    offline::ProgressBar bar("torque");
    lines = measure_torque(setup, [&](double share, const char* what) { bar.show(share, what); });
  }
  publish({.print_table = [&] { print_table(lines, setup); },
           .json = [&] { return to_sweep(lines, setup); },
           .write_files = [&](const auto& folder) { write_files(lines, setup, folder); }},
          common);
}

}  // namespace

void add_torque(CLI::App& app, const offline::Common& common) {
  auto* command = app.add_subcommand("torque", "measure margins of contacts that carry force and torque");
  auto setup = std::make_shared<TorqueSetup>();
  command->add_option("--frames", setup->frames, "single frames of each kind")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  add_grasps_option(*command, setup->grasps, "grasps of each kind");
  add_sides_option(*command, setup->sides);
  add_methods_option(*command, setup->methods);
  add_noise_option(*command, setup->noise);
  add_threads_option(*command, setup->threads);
  command->callback([&common, setup] { run(common, *setup); });
}

}  // namespace lab
