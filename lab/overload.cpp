// `slipd-lab overload`: what becomes of estimates where an estimator cannot keep up with its sensor and gets
// one frame of k.
#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "lab/command.hpp"
#include "lab/options.hpp"
#include "lab/overload/report.hpp"
#include "tools/offline/progress.hpp"

namespace lab {
namespace {

using namespace slipd;

struct OverloadOptions {
  OverloadSetup setup;
  std::vector<std::size_t> sides{4, 16, 32};
  std::vector<std::string> methods{"moments", "fit", "registered", "svd-knn"};
  std::vector<unsigned> every{1, 2, 5, 10, 20, 50};
  std::vector<unsigned> at_random{5, 20};
};

std::vector<OverloadCase> cases(const OverloadOptions& options) {
  std::vector<OverloadCase> all;
  for (const unsigned k : options.every) all.push_back({Skipping::regular, k});
  for (const Skipping skipping : {Skipping::random, Skipping::bursts}) {
    for (const unsigned k : options.at_random) all.push_back({skipping, k});
  }
  return all;
}

// The lines of one layout and method; none where slipd takes another method for this layout.
void measure(std::size_t side, const std::string& name, const OverloadOptions& options,
             std::vector<OverloadLine>& lines) {
  const MethodChoice choice = method_choices().at(name);
  offline::ProgressBar bar(title_of(side, name));
  bar.show(0, "training");
  const Estimator estimator =
      make_estimator(paper_chain(side, choice, options.setup.sensing.noise), options.setup.threads);
  if (choice != MethodChoice::automatic && to_string(estimator.method()) != name) return;
  const auto all = cases(options);
  for (std::size_t i = 0; i < all.size(); ++i) {
    OverloadLine line = measure_overload(estimator, all[i], options.setup, [&](double share) {
      bar.show((static_cast<double>(i) + share) / static_cast<double>(all.size()), "grasps");
    });
    line.columns = side;
    line.method = name;
    lines.push_back(std::move(line));
  }
}

void run(const offline::Common& common, OverloadOptions options) {
  options.setup.seed = common.seed;
  std::vector<OverloadLine> lines;
  for (const std::size_t side : options.sides) {
    for (const auto& method : options.methods) measure(side, method, options, lines);
  }
  publish({.print_table = [&] { print_table(lines, options.setup); },
           .json = [&] { return to_sweep(lines, options.setup); },
           .write_files = [&](const auto& folder) { write_files(lines, options.setup, folder); }},
          common);
}

}  // namespace

void add_overload(CLI::App& app, const offline::Common& common) {
  auto* command =
      app.add_subcommand("overload", "measure the whole chain against the truth when frames are skipped");
  auto options = std::make_shared<OverloadOptions>();
  options->setup.sensing.frame_s = 0.001;
  add_grasps_option(*command, options->setup.grasps, "grasps for each line of the result");
  add_sides_option(*command, options->sides);
  add_methods_option(*command, options->methods);
  command->add_option("--every", options->every, "keep every Nth frame, for each N of this list")
      ->delimiter(',')
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command
      ->add_option("--at-random", options->at_random,
                   "keep one frame in N on average, at random and in bursts, for each N of this list")
      ->delimiter(',')
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  add_noise_options(*command, options->setup.sensing.noise, options->setup.sensing.kind);
  add_frame_option(*command, options->setup.sensing.frame_s);
  add_threads_option(*command, options->setup.threads);
  command->callback([&common, options] { run(common, *options); });
}

}  // namespace lab
