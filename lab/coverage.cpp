// `slipd-lab coverage`: whether sigma is meant over a grasp's life. Plays whole grasps against the truth and
// counts how many margins lie within two and three of their sigmas, and in which phase of the grasp the
// others do.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "lab/command.hpp"
#include "lab/coverage/measure.hpp"
#include "lab/histories/drive.hpp"
#include "paper/model_setup.hpp"
#include "paper/train.hpp"
#include "tools/offline/gnuplot.hpp"
#include "tools/offline/progress.hpp"

namespace lab {
namespace {

using namespace slipd;
using nlohmann::ordered_json;

struct CoverageOptions {
  CoverageSetup setup;
  std::vector<std::size_t> sides{4, 8, 16, 32, 100};
  std::vector<std::string> methods{"moments", "fit", "registered", "auto"};
  std::vector<double> rates_hz{1000};
  std::vector<std::string> grasps_of{"cycle", "histories"};
  std::optional<double> friction;
};

const std::map<std::string, MethodChoice> kCoverageMethods{{"auto", MethodChoice::automatic},
                                                           {"svd-knn", MethodChoice::svd_knn},
                                                           {"registered", MethodChoice::registered},
                                                           {"moments", MethodChoice::moments},
                                                           {"fit", MethodChoice::fit},
                                                           {"closing", MethodChoice::closing},
                                                           {"block-fit", MethodChoice::block_fit}};

struct CoverageLine {
  std::size_t side = 0;
  std::string method, used;  // as asked for, as taken
  std::string grasps;        // cycle or histories
  double rate_hz = 0;
  Coverage found;
};

// `traced` gets a line for each frame where it is not null.
std::vector<CoverageLine> measure_layout(std::size_t side, const std::string& method, CoverageOptions options,
                                         std::ostream* traced) {
  ChainSetup chain = paper_chain(side, kCoverageMethods.at(method), options.setup.noise);
  chain.friction = options.friction;
  offline::ProgressBar bar(std::to_string(side) + "x" + std::to_string(side) + " " + method);
  std::shared_ptr<const Model> model;
  if (needs_model(chain)) {
    bar.show(0, "training");
    model = std::make_shared<const Model>(train(model_setup_of(chain), options.setup.threads));
  }
  const std::string used(to_string(EstimatorChain(chain, model).method()));
  std::vector<CoverageLine> lines;
  for (const double rate_hz : options.rates_hz) {
    for (const std::string& of : options.grasps_of) {
      options.setup.rate_hz = rate_hz;
      if (traced != nullptr) {
        options.setup.watch = [&](const CoverageSample& at) {
          *traced << side << ',' << used << ',' << rate_hz << ',' << of << ',' << at.grasp << ',' << at.time_s
                  << ',' << at.phase << ',' << at.normal_n << ',' << at.shear_n << ',' << at.truth.friction
                  << ',' << at.truth.gamma << ',' << at.traced << ',' << at.estimate.gamma.value_or(kUnknown)
                  << ',' << at.estimate.sigma.value_or(kUnknown) << ','
                  << at.estimate.friction.value_or(kUnknown) << ','
                  << at.estimate.friction_sigma.value_or(kUnknown) << ',' << to_string(at.estimate.state)
                  << ',' << to_string(at.estimate.method) << '\n';
        };
      }
      const auto done = [&](double share) { bar.show(share, of.c_str()); };
      lines.push_back({side, method, used, of, rate_hz,
                       of == "cycle" ? measure_cycle(chain, model, options.setup, done)
                                     : measure_histories(chain, model, options.setup, done)});
    }
  }
  return lines;
}

void print_tally(const std::string& what, const CoverageTally& tally) {
  std::printf("  %-14s %8.0f   %5.1f %%   %.4f   %6.2f %%  %6.2f %%  %7.0f   %7.0f   %.3f   %.4f  %7.0f\n",
              what.c_str(), tally.answers(), 100 * tally.answered(), tally.mean_error(),
              100 * tally.within_two_sigma(), 100 * tally.within_three_sigma(), tally.beyond_three_sigma(),
              tally.too_safe(), tally.worst(), tally.least_sigma(), tally.untraced());
}

void print_table(const std::vector<CoverageLine>& lines, const CoverageOptions& options) {
  std::printf(
      "Whole grasps, %zu a line: the cycle that sim plays by default, and random histories. Counted are "
      "answers in state "
      "ok;\napart: those given while friction has changed and no frame has shown it yet. Too safe: more than "
      "%g above the "
      "truth.\n\n"
      "  during          answers  answered  mean err   2 sigma   3 sigma  beyond 3  too safe  worst  least "
      "sigma   apart\n",
      options.setup.grasps, kTooSafe);
  for (const CoverageLine& line : lines) {
    std::printf("%zu x %zu, %s (%s), %s at %g Hz\n", line.side, line.side, line.method.c_str(),
                line.used.c_str(), line.grasps.c_str(), line.rate_hz);
    print_tally("everything", line.found.all);
    for (const auto& [phase, tally] : line.found.by_phase) print_tally(phase, tally);
  }
}

ordered_json coverage_json(const CoverageTally& tally) {
  return {{"frames", tally.frames()},
          {"answered", tally.answered()},
          {"answers", tally.answers()},
          {"mean_error", tally.mean_error()},
          {"within_two_sigma", tally.within_two_sigma()},
          {"within_three_sigma", tally.within_three_sigma()},
          {"beyond_three_sigma", tally.beyond_three_sigma()},
          {"too_safe", tally.too_safe()},
          {"worst_error", tally.worst()},
          {"least_sigma", tally.least_sigma()},
          {"untraced", tally.untraced()}};
}

ordered_json coverage_json(const std::vector<CoverageLine>& lines, const CoverageOptions& options) {
  ordered_json rows = ordered_json::array();
  for (const CoverageLine& line : lines) {
    ordered_json row{{"columns", line.side}, {"method", line.method},
                     {"used", line.used},    {"rate_hz", line.rate_hz},
                     {"of", line.grasps},    {"all", coverage_json(line.found.all)}};
    for (const auto& [phase, tally] : line.found.by_phase) row["during"][phase] = coverage_json(tally);
    rows.push_back(std::move(row));
  }
  return {{"grasps", options.setup.grasps},
          {"noise", options.setup.noise},
          {"too_safe", kTooSafe},
          {"rows", std::move(rows)}};
}

void run(const offline::Common& common, CoverageOptions options) {
  options.setup.seed = common.seed;
  std::ostringstream traced;
  traced << "side,method,rate_hz,of,grasp,time_s,phase,normal_n,shear_n,friction,truth,traced,gamma,sigma,mu,"
            "mu_sigma,"
            "state,by\n";
  std::vector<CoverageLine> lines;
  for (const std::size_t side : options.sides) {
    for (const std::string& method : options.methods) {
      const auto found = measure_layout(side, method, options, common.out.empty() ? nullptr : &traced);
      lines.insert(lines.end(), found.begin(), found.end());
    }
  }
  if (common.json) {
    std::cout << coverage_json(lines, options).dump(2) << '\n';
  } else {
    print_table(lines, options);
  }
  if (common.out.empty()) return;
  std::filesystem::create_directories(common.out);
  offline::write_file(common.out / "coverage.csv", traced.str());
}

}  // namespace

void add_coverage(CLI::App& app, const offline::Common& common) {
  auto* command =
      app.add_subcommand("coverage", "whether margins lie within their sigmas, over whole grasps");
  auto options = std::make_shared<CoverageOptions>();
  command->add_option("--grasps", options->setup.grasps, "of each line")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--sides", options->sides, "taxels along each side of the pad")
      ->delimiter(',')
      ->check(CLI::Range(2, 200))
      ->capture_default_str();
  command->add_option("--methods", options->methods, "auto, moments, fit, registered, svd-knn")
      ->delimiter(',')
      ->check(CLI::IsMember(kCoverageMethods))
      ->capture_default_str();
  command->add_option("--rates", options->rates_hz, "frames a second")
      ->delimiter(',')
      ->check(CLI::Range(10.0, 10000.0))
      ->capture_default_str();
  command->add_option("--of", options->grasps_of, "cycle, histories")
      ->delimiter(',')
      ->check(CLI::IsMember({"cycle", "histories"}))
      ->capture_default_str();
  command->add_option("--noise", options->setup.noise, "of histories, half-width, a fraction")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_option("--friction", options->friction, "the estimator is given this coefficient of friction")
      ->check(CLI::Range(0.01, 10.0));
  command->add_option("--threads", options->setup.threads)->check(CLI::Range(1, 4))->capture_default_str();
  command->callback([&common, options] { run(common, *options); });
}

}  // namespace lab
