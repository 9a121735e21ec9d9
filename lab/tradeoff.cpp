// `slipd-lab tradeoff`: error against run time, for each method and setting on each layout and kind of noise.
#include <CLI/CLI.hpp>
#include <memory>

#include "lab/command.hpp"
#include "lab/options.hpp"
#include "lab/report.hpp"
#include "lab/tradeoff/report.hpp"
#include "lab/tradeoff/shapes.hpp"
#include "tools/offline/progress.hpp"

namespace lab {
namespace {

void run_shapes(const offline::Common& common, const CLI::App& command, const TradeoffOptions& options) {
  std::vector<ShapeLine> lines;
  {
    offline::ProgressBar bar("tradeoff");
    lines = measure_shapes(options, [&](double share, const char* layout) { bar.show(share, layout); });
  }
  publish({.print_table = [&] { print_shapes(lines, options.contacts); },
           .json = [&] { return shapes_to_sweep(lines, options.contacts); }},
          common, options.shard, command);
}

void run(const offline::Common& common, const CLI::App& command, TradeoffOptions options, bool shapes) {
  offline::refuse_files(options.shard, common);
  options.seed = common.seed;
  if (shapes) return run_shapes(common, command, options);
  std::vector<Line> lines;
  {
    offline::ProgressBar bar("tradeoff");
    lines = measure_tradeoffs(options, [&](double share, const char* layout) { bar.show(share, layout); });
  }
  publish({.print_table = [&] { print_table(lines, options.contacts); },
           .json = [&] { return to_sweep(lines, options.contacts); },
           .write_files = [&](const auto& folder) { write_files(lines, options.contacts, folder); }},
          common, options.shard, command);
}

}  // namespace

void add_tradeoff(CLI::App& app, const offline::Common& common) {
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
  add_threads_option(*command, options->threads);
  auto shapes = std::make_shared<bool>(false);
  command->add_flag(
      "--shapes", *shapes,
      "instead: method fit on elliptic contacts and under a skin, against the Cramer-Rao bound");
  offline::add_shard_option(*command, options->shard);
  command->callback([&common, command, options, shapes] { run(common, *command, *options, *shapes); });
}

}  // namespace lab
