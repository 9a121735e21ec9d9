// `slipd-lab method-table`: measures the table that `auto` chooses by, and prints it as it stands in
// core/chain/setup/method_table_rows.inc. Of an optimised build, on a machine that does nothing else.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "lab/command.hpp"
#include "lab/method_table/measure.hpp"
#include "paper/validation/tradeoff.hpp"
#include "tools/offline/progress.hpp"

namespace lab {
namespace {

using namespace slipd;

struct MethodTableOptions {
  MethodTableWork work;
  std::vector<double> sizes{std::begin(kMethodTableSizes), std::end(kMethodTableSizes)};
};

void print(const MeasuredTableRow& measured) {
  const MethodTableRow& row = measured.row;
  std::printf("{%s, %g, Method::%s, %.3g, %.3f, %.1f, %.1f},  // +- %.2g\n",
              row.under_skin ? "true" : "false", row.taxels_along_radius,
              row.method == Method::block_fit ? "block_fit" : std::string(to_string(row.method)).c_str(),
              row.mean_error, row.answered, row.p50_us, row.p99_us, measured.error_sigma);
}

nlohmann::ordered_json as_json(const MeasuredTableRow& measured) {
  const MethodTableRow& row = measured.row;
  return {{"under_skin", row.under_skin},
          {"taxels_along_radius", row.taxels_along_radius},
          {"method", to_string(row.method)},
          {"mean_error", row.mean_error},
          {"error_sigma", measured.error_sigma},
          {"answered", row.answered},
          {"p50_us", row.p50_us},
          {"p99_us", row.p99_us}};
}

void run_method_table(const offline::Common& common, MethodTableOptions options) {
  options.work.seed = common.seed;
  offline::ProgressBar progress("method-table");
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  if (!common.json) std::printf("// Made by slipd-lab method-table on %s.\n", processor_name().c_str());
  double done = 0;
  for (const bool under_skin : {false, true}) {
    for (const double size : options.sizes) {
      for (const MeasuredTableRow& row : measure_method_table_rows(size, under_skin, options.work)) {
        common.json ? rows.push_back(as_json(row)) : print(row);
      }
      std::fflush(stdout);
      progress.show(++done / (2 * static_cast<double>(options.sizes.size())), "contacts");
    }
  }
  if (common.json)
    std::cout << nlohmann::ordered_json{{"processor", processor_name()}, {"rows", rows}}.dump(2) << '\n';
}

}  // namespace

void add_method_table(CLI::App& app, const offline::Common& common) {
  auto* command =
      app.add_subcommand("method-table", "error and time of the methods by the size of contacts, for auto");
  auto options = std::make_shared<MethodTableOptions>();
  command->add_option("--contacts", options->work.contacts, "contacts of a repeat")
      ->check(CLI::Range(2, 1000000))
      ->capture_default_str();
  command->add_option("--repeats", options->work.repeats, "how often other contacts are measured")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
  command->add_option("--sizes", options->sizes, "taxels along a contact's radius")->delimiter(',');
  command->callback([&common, options] { run_method_table(common, *options); });
}

}  // namespace lab
