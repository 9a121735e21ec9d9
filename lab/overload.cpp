// `slipd-lab overload`: what becomes of estimates where an estimator cannot keep up with its sensor and gets
// one frame of k.
#include <CLI/CLI.hpp>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lab/command.hpp"
#include "lab/noise_options.hpp"
#include "lab/overload/report.hpp"
#include "paper/model_setup.hpp"
#include "paper/train.hpp"
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

const std::map<std::string, std::pair<MethodChoice, Method>> kOverloadMethods{
    {"svd-knn", {MethodChoice::svd_knn, Method::svd_knn}},
    {"registered", {MethodChoice::registered, Method::registered}},
    {"moments", {MethodChoice::moments, Method::moments}},
    {"fit", {MethodChoice::fit, Method::fit}}};

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
  const auto& [choice, method] = kOverloadMethods.at(name);
  const ChainSetup chain = paper_chain(side, choice, options.setup.sensing.noise);
  offline::ProgressBar bar(std::to_string(side) + "x" + std::to_string(side) + " " + name);
  std::shared_ptr<const Model> model;
  if (needs_model(chain)) {
    bar.show(0, "training");
    model = std::make_shared<const Model>(train(model_setup_of(chain), options.setup.threads));
  }
  if (EstimatorChain(chain, model).method() != method) return;
  const auto all = cases(options);
  for (std::size_t i = 0; i < all.size(); ++i) {
    OverloadLine line = measure_overload(chain, model, all[i], options.setup, [&](double share) {
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
  if (common.json) {
    std::cout << to_json(lines, options.setup).dump(2) << '\n';
  } else {
    print_table(lines, options.setup);
  }
  if (!common.out.empty()) write_files(lines, common.out);
}

}  // namespace

void add_overload(CLI::App& app, const offline::Common& common) {
  auto* command =
      app.add_subcommand("overload", "measure the whole chain against the truth when frames are skipped");
  auto options = std::make_shared<OverloadOptions>();
  options->setup.sensing.frame_s = 0.001;
  command->add_option("--grasps", options->setup.grasps, "grasps for each line of the result")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--sides", options->sides, "taxels along each side of the pad")
      ->delimiter(',')
      ->check(CLI::Range(2, 200))
      ->capture_default_str();
  command->add_option("--methods", options->methods, "methods, out of moments, fit, registered, svd-knn")
      ->delimiter(',')
      ->check(CLI::IsMember(kOverloadMethods))
      ->capture_default_str();
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
  command->add_option("--frame-s", options->setup.sensing.frame_s, "time between two frames of the sensor, s")
      ->check(CLI::Range(1e-4, 0.1))
      ->capture_default_str();
  command->add_option("--threads", options->setup.threads, "threads to compute with")
      ->check(CLI::Range(1, 4))
      ->capture_default_str();
  command->callback([&common, options] { run(common, *options); });
}

}  // namespace lab
