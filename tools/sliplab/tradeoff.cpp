// `sliplab tradeoff`: error against run time, for each method and setting on each layout and kind of noise.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/sliplab/command.hpp"
#include "tools/sliplab/progress.hpp"
#include "tools/sliplab/tradeoff/report.hpp"

namespace sliplab {
namespace {

void run(const Common& common, TradeoffOptions options) {
  options.seed = common.seed;
  std::vector<Line> lines;
  {
    ProgressBar bar("tradeoff");
    lines = measure_tradeoffs(options, [&](double share, const char* layout) { bar.show(share, layout); });
  }
  if (common.json) {
    std::cout << to_json(lines, options.contacts).dump(2) << '\n';
  } else {
    print_table(lines, options.contacts);
  }
  if (!common.out.empty()) write_files(lines, common.out);
}

}  // namespace

void add_tradeoff(CLI::App& app, const Common& common) {
  auto* command =
      app.add_subcommand("tradeoff", "measure error and run time for each method, layout and noise");
  auto options = std::make_shared<TradeoffOptions>();
  command->add_option("--contacts", options->contacts, "contacts for each row of the result")
      ->check(CLI::Range(10, 1000000))
      ->capture_default_str();
  command
      ->add_option(
          "--layouts", options->layouts,
          "layouts: taxels along each side of the pad (100, 32, 16, 8, 4), or wrench for one force sensor")
      ->delimiter(',')
      ->check(CLI::IsMember({"100", "32", "16", "8", "4", "wrench"}))
      ->capture_default_str();
  command->add_flag("!--no-models", options->models, "leave out the methods that need a trained model");
  command->add_option("--threads", options->threads, "threads for training")
      ->check(CLI::Range(1, 4))
      ->capture_default_str();
  command->callback([&common, options] { run(common, *options); });
}

}  // namespace sliplab
