// `sliplab replay`: recordings through the chain of the daemon, as fast as it goes. The scene is parsed and
// the files are decoded by the same code; every row of a file gives one line of estimates.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/offline/gnuplot.hpp"
#include "tools/sliplab/command.hpp"
#include "tools/sliplab/replay/label.hpp"
#include "tools/sliplab/replay/run.hpp"
#include "tools/sliplab/replay/table.hpp"

namespace sliplab {
namespace {

struct ReplayOptions {
  std::string scene, sensor, estimates;
  std::vector<std::string> files;
  std::filesystem::path picture, label;
  std::optional<double> releasing_from_s;
  offline::Shard shard;  // of files and sensors
};

nlohmann::json summary_of(const ReplayRun& run) {
  nlohmann::json summary = to_json(summarize(run));
  summary["sensor"] = run.sensor;
  summary["file"] = run.file;
  return summary;
}

void print(const ReplayRun& run, const ReplaySummary& summary) {
  std::cerr << run.sensor << " " << run.file << ": " << summary.rows << " rows, " << summary.contact
            << " in contact, " << summary.with_margin << " with a margin, " << summary.slip_rows
            << " with alert slip";
  if (summary.first_slip_s) std::cerr << ", the first at " << *summary.first_slip_s << " s";
  std::cerr << '\n';
  if (summary.repeated > 0)
    std::cerr << "  " << summary.repeated
              << " of the rows repeat the row before: they are no new measurement, and count for nothing\n";
  for (const std::string& remark : remarks_on_time(run, summary)) std::cerr << "  " << remark << '\n';
}

void run_replay(const offline::Common& common, const CLI::App& command, const ReplayOptions& options) {
  const bool json = common.json || !options.shard.whole();
  if (options.estimates == "-" && !options.shard.whole())
    throw offline::WrongUse("a shard prints its part: write its estimates to a file, not to standard output");
  const std::vector<ReplayRun> runs =
      replay(options.scene, options.sensor, options.files, options.shard, options.releasing_from_s);
  if (!options.estimates.empty()) {
    const std::string table = estimates_csv(runs);
    if (options.estimates == "-") {
      std::cout << table;
    } else {
      offline::write_file(options.estimates, table);
    }
  }
  offline::SweepResult sweep;
  for (const ReplayRun& run : runs) {
    nlohmann::json summary = summary_of(run);
    if (!json) print(run, summarize(run));
    if (!options.label.empty() && run.unit) {
      const LabelScore score = score_alerts(run, read_labels(options.label, run));
      summary["label"] = to_json(score);
      if (!json) std::cerr << "  " << describe(score) << '\n';
    }
    if (run.unit) sweep.add_row(*run.unit, summary);
    if (!run.fault.empty()) std::cerr << "sliplab: " << run.fault << '\n';
  }
  if (json && options.estimates != "-") offline::print_json(sweep, options.shard, common, command);
  if (!options.picture.empty()) draw(runs, options.picture);
}

}  // namespace

void add_replay(CLI::App& app, const offline::Common& common) {
  auto* command = app.add_subcommand("replay", "run recordings through slipd's estimator, without a daemon");
  auto options = std::make_shared<ReplayOptions>();
  command->add_option("--scene", options->scene, "the configuration")->required()->check(CLI::ExistingFile);
  command->add_option("--file", options->files,
                      "a CSV or recording instead of the scene's; SENSOR=FILE for one sensor");
  command->add_option("--sensor", options->sensor, "only this sensor of the scene");
  command->add_option("--estimates", options->estimates,
                      "the table of estimates as CSV; - for standard output");
  command->add_option(
      "--releasing-from", options->releasing_from_s,
      "the robot lets go of the object from then on, s: sensors of displacements show no slide");
  command->add_option("--picture", options->picture, "margin, forces and alerts over time, as SVG");
  command->add_option("--label", options->label,
                      "CSV with a column slip, 0 or 1 in each row: the alerts are scored against it");
  offline::add_shard_option(*command, options->shard);
  command->callback([&common, command, options] { run_replay(common, *command, *options); });
}

}  // namespace sliplab
