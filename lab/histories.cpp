// `slipd-lab histories`: the whole estimator chain over random grasps (regrip, unloading, reversal, slip,
// changes of friction), frame by frame against the truth. It measures what the estimator remembers from frame
// to frame.
#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lab/command.hpp"
#include "lab/estimator.hpp"
#include "lab/histories/report.hpp"
#include "lab/options.hpp"
#include "tools/offline/progress.hpp"
#include "tools/offline/sweep.hpp"

namespace lab {
namespace {

using namespace slipd;

const std::map<std::string, GivenFriction> kGiven{{"none", GivenFriction::none},
                                                  {"constant", GivenFriction::constant},
                                                  {"range", GivenFriction::range},
                                                  {"value", GivenFriction::value}};

struct HistoriesOptions {
  HistoriesSetup setup;
  std::vector<std::size_t> sides{100, 16};
  std::vector<std::string> methods{"moments", "fit"};
  offline::Shard shard;  // of sides and methods
};

const std::map<std::string, SkinBase> kBases{{slipd::to_string(SkinBase::half_space), SkinBase::half_space},
                                             {slipd::to_string(SkinBase::rigid), SkinBase::rigid}};

void run(const offline::Common& common, const CLI::App& command, const HistoriesOptions& options) {
  offline::refuse_files(options.shard, common);
  std::vector<HistoriesLine> lines;
  std::size_t unit = 0;
  for (const std::size_t side : options.sides) {
    for (const auto& method : options.methods) {
      if (!options.shard.has(unit++)) continue;
      offline::ProgressBar bar(title_of(side, method));
      lines.push_back(measure_moves(side, method, options.setup, common.seed,
                                    [&](double share) { bar.show(share, "grasps"); }));
      lines.back().unit = unit - 1;
    }
  }
  publish({.print_table = [&] { print_table(lines, options.setup); },
           .json = [&] { return to_sweep(lines, options.setup); },
           .write_files = [&](const auto& folder) { write_files(lines, folder); }},
          common, options.shard, command);
}

}  // namespace

void add_histories(CLI::App& app, const offline::Common& common) {
  auto* command =
      app.add_subcommand("histories", "measure the whole chain on random grasps against the truth");
  auto options = std::make_shared<HistoriesOptions>();
  add_grasps_option(*command, options->setup.grasps, "grasps for each layout and method");
  add_sides_option(*command, options->sides);
  add_methods_option(*command, options->methods);
  add_noise_options(*command, options->setup.sensing.noise, options->setup.sensing.kind);
  command->add_option("--skin-mm", options->setup.skin_mm, "depth of the taxels under the surface, known, mm")
      ->check(CLI::Range(0.0, 5.0))
      ->capture_default_str();
  command
      ->add_option("--depth-taken", options->setup.depth_taken,
                   "depth that the scene gives, divided by the true one")
      ->check(CLI::Range(0.2, 5.0))
      ->capture_default_str();
  command
      ->add_option(
          "--friction", options->setup.friction,
          "what the scene gives of friction: none; of a friction that stays constant, constant gives "
          "nothing, range a range a factor of 1.6 wide, and value itself")
      ->transform(CLI::CheckedTransformer(kGiven, CLI::ignore_case))
      ->default_str("none");
  command
      ->add_option("--axes", options->setup.sensing.stretch,
                   "long over short axis of the contact, which lies in any direction to the pull")
      ->check(CLI::Range(1.0, 3.0))
      ->capture_default_str();
  command
      ->add_option("--power", options->setup.sensing.power,
                   "n of an object whose gap grows as r^n: 2 is a sphere, 8 is nearly flat")
      ->check(CLI::Range(2.0, 8.0))
      ->capture_default_str();
  const auto add_base = [&](const char* option, SkinBase& base, const char* about) {
    command->add_option(option, base, about)
        ->transform(CLI::CheckedTransformer(kBases, CLI::ignore_case))
        ->default_str("half_space");
  };
  add_base("--base", options->setup.base, "what the skin lies on, see skin.base in slipd.json(5)");
  add_base("--base-taken", options->setup.base_taken, "what the method takes it to lie on");
  add_frame_option(*command, options->setup.sensing.frame_s);
  add_threads_option(*command, options->setup.threads);
  offline::add_shard_option(*command, options->shard);
  command->callback([&common, command, options] { run(common, *command, *options); });
}

}  // namespace lab
