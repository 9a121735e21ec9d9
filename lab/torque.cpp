// `slipd-lab torque`: margins and friction of contacts that carry force and torque, for each method and
// layout.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "lab/command.hpp"
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
  if (common.json) {
    std::cout << to_json(lines, setup).dump(2) << '\n';
  } else {
    print_table(lines, setup);
  }
  if (!common.out.empty()) write_files(lines, common.out);
}

}  // namespace

void add_torque(CLI::App& app, const offline::Common& common) {
  auto* command = app.add_subcommand("torque", "measure margins of contacts that carry force and torque");
  auto setup = std::make_shared<TorqueSetup>();
  command->add_option("--frames", setup->frames, "single frames of each kind")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command->add_option("--grasps", setup->grasps, "grasps of each kind")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--sides", setup->sides, "taxels along each side of the pad")
      ->delimiter(',')
      ->check(CLI::Range(2, 200))
      ->capture_default_str();
  command->add_option("--methods", setup->methods, "auto, fit, moments, registered")
      ->delimiter(',')
      ->check(CLI::IsMember({"auto", "fit", "moments", "registered"}))
      ->capture_default_str();
  command->add_option("--noise", setup->noise, "half-width, a fraction of the largest pressure")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_option("--threads", setup->threads)->check(CLI::Range(1, 4))->capture_default_str();
  command->callback([&common, setup] { run(common, *setup); });
}

}  // namespace lab
