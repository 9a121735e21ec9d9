// `slipd-lab gels`: how soon slipd tells that an object slides on a camera's gel, and its false alerts.
#include <CLI/CLI.hpp>
#include <memory>

#include "lab/command.hpp"
#include "lab/gels/report.hpp"
#include "lab/options.hpp"
#include "tools/offline/progress.hpp"

namespace lab {
namespace {

void run(const offline::Common& common, GelSetup setup) {
  setup.seed = common.seed;
  std::vector<GelLine> lines;
  {
    offline::ProgressBar bar("gels");
    lines = measure_gels(setup, [&](double share) { bar.show(share, "grasps"); });
  }
  publish({.print_table = [&] { print_table(lines, setup); }, .json = [&] { return to_sweep(lines, setup); }},
          common);
}

}  // namespace

void add_gels(CLI::App& app, const offline::Common& common) {
  auto* command =
      app.add_subcommand("gels", "measure how soon slides on a camera's gel are told, and false alerts");
  auto setup = std::make_shared<GelSetup>();
  add_grasps_option(*command, setup->grasps);
  command->add_option("--rate-hz", setup->rate_hz, "pictures a second")
      ->check(CLI::Range(5.0, 200.0))
      ->capture_default_str();
  command->add_option("--noise-px", setup->noise_px, "of the field, standard deviation")
      ->check(CLI::Range(0.0, 5.0))
      ->capture_default_str();
  add_threads_option(*command, setup->threads);
  command->callback([&common, setup] { run(common, *setup); });
}

}  // namespace lab
