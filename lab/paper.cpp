// slipd-lab paper: repeats the paper's experiment (its sections II.B to III.B), prints its figures next to
// slipd's, and varies it: a split by contact, contacts off the middle.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "lab/command.hpp"
#include "lab/options.hpp"
#include "lab/paper/figures.hpp"
#include "lab/paper/protocol.hpp"
#include "lab/paper/table.hpp"
#include "tools/offline/progress.hpp"

namespace lab {
namespace {

// The row of the figures: the paper's case, noise 4 %.
const Row& shown_in_figures(const std::vector<Row>& rows) {
  return *std::find_if(rows.begin(), rows.end(), [](const Row& row) {
    return row.experiment.quantity == slipd::Quantity::alpha && row.experiment.noise == 0.04;
  });
}

void run_command(const ProtocolOptions& options, const offline::Common& common) {
  std::vector<Row> rows;
  {
    offline::ProgressBar bar("paper");
    rows = run_protocol(options, [&](double share, const char* what) { bar.show(share, what); });
  }
  if (common.json) {
    std::cout << nlohmann::json{{"rows", to_json(rows)}, {"fast", options.fast}} << '\n';
  } else {
    print_table(std::cout, rows);
  }
  if (!common.out.empty()) {
    write_figures(common.out, shown_in_figures(rows));
    if (!common.json) std::cout << "\nfigures 3 and 4 are in " << common.out.string() << '\n';
  }
}

}  // namespace

void add_paper(CLI::App& app, const offline::Common& common) {
  auto options = std::make_shared<ProtocolOptions>();
  CLI::App* command =
      app.add_subcommand("paper", "repeat the paper's experiment, and vary its split and its contacts");
  command
      ->add_option("--seeds", options->seeds,
                   "number of repetitions, each with its own contacts, noise and split")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  add_threads_option(*command, options->threads);
  command->add_flag("--fast", options->fast,
                    "few contacts on a small grid: a test of the command; its figures mean nothing");
  command->callback([options, &common] {
    options->first_seed = common.seed;
    run_command(*options, common);
  });
}

}  // namespace lab
