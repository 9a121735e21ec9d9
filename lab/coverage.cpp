// `slipd-lab coverage`: whether sigma is meant over a grasp's life. Plays whole grasps against the truth and
// counts how many margins lie within two and three of their sigmas, and in which phase of the grasp the
// others do.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "lab/command.hpp"
#include "lab/coverage/measure.hpp"
#include "lab/options.hpp"
#include "lab/report.hpp"
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

struct CoverageLine {
  std::size_t side = 0;
  std::string method, used;  // as asked for, as taken
  std::string grasps;        // cycle, histories or holds
  double rate_hz = 0;
  Coverage found;
};

constexpr const char* kTracedHead =
    "side,method,rate_hz,of,grasp,time_s,phase,normal_n,shear_n,friction,truth,traced,gamma,sigma,mu,mu_"
    "sigma,"
    "state,by\n";

void write_traced(std::ostream& out, const CoverageLine& line, const CoverageSample& of) {
  const GraspMoment& at = of.sample.at;
  const Estimate& estimate = of.sample.estimate();
  out << line.side << ',' << line.used << ',' << line.rate_hz << ',' << line.grasps << ',' << of.grasp << ','
      << at.time_s << ',' << of.phase << ',' << at.normal_n << ',' << at.shear_n << ',' << at.truth.friction
      << ',' << at.truth.gamma << ',' << of.sample.traced << ',' << estimate.gamma.value_or(kUnknown) << ','
      << estimate.sigma.value_or(kUnknown) << ',' << estimate.friction.value_or(kUnknown) << ','
      << estimate.friction_sigma.value_or(kUnknown) << ',' << to_string(estimate.state) << ','
      << to_string(estimate.method) << '\n';
}

// `traced` gets a line for each frame where it is not null.
std::vector<CoverageLine> measure_layout(std::size_t side, const std::string& method, CoverageOptions options,
                                         std::ostream* traced) {
  ChainSetup chain = paper_chain(side, method_choices().at(method), options.setup.noise);
  chain.friction = options.friction;
  offline::ProgressBar bar(title_of(side, method));
  bar.show(0, "training");
  const Estimator estimator = make_estimator(chain, options.setup.threads);
  const std::string used(to_string(estimator.method()));
  std::vector<CoverageLine> lines;
  for (const double rate_hz : options.rates_hz) {
    for (const std::string& of : options.grasps_of) {
      CoverageLine line{side, method, used, of, rate_hz, {}};
      options.setup.rate_hz = rate_hz;
      if (traced != nullptr)
        options.setup.watch = [&](const CoverageSample& sample) { write_traced(*traced, line, sample); };
      const auto measure_grasps = of == "cycle"   ? measure_cycle
                                  : of == "holds" ? measure_holds
                                                  : measure_histories;
      line.found =
          measure_grasps(estimator, options.setup, [&](double share) { bar.show(share, of.c_str()); });
      lines.push_back(std::move(line));
    }
  }
  return lines;
}

void print_tally(const std::string& what, const CoverageTally& tally) {
  std::printf("  %-14s %8.0f   %5.1f %%   %.4f   %6.2f %%  %6.2f %%  %7.0f   %7.0f   %.3f   %.4f  %7.0f\n",
              what.c_str(), tally.traced.answers(), 100 * tally.answered(), tally.traced.mean_error(),
              100 * tally.traced.within(2), 100 * tally.traced.within(3), tally.traced.beyond(3),
              tally.traced.overestimates(), tally.traced.worst(), tally.least_sigma(),
              tally.untraced.answers());
}

void print_table(const std::vector<CoverageLine>& lines, const CoverageOptions& options) {
  std::printf(
      "Whole grasps, %zu a line: the cycle that sim plays by default, random histories, or loads that are "
      "held. Counted are answers in state ok;\napart: those given while friction has changed and no frame "
      "has shown it yet. Too safe: more than "
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
  const Tally& traced = tally.traced;
  return {{"frames", tally.frames()},
          {"answered", tally.answered()},
          {"answers", traced.answers()},
          {"mean_error", traced.mean_error()},
          {"within_two_sigma", traced.within(2)},
          {"within_three_sigma", traced.within(3)},
          {"beyond_three_sigma", traced.beyond(3)},
          {"too_safe", traced.overestimates()},
          {"worst_error", traced.worst()},
          {"least_sigma", tally.least_sigma()},
          {"untraced", tally.untraced.answers()}};
}

offline::SweepResult to_sweep(const std::vector<CoverageLine>& lines, const CoverageOptions& options) {
  ordered_json rows = ordered_json::array();
  for (const CoverageLine& line : lines) {
    ordered_json row{{"columns", line.side}, {"method", line.method},
                     {"used", line.used},    {"rate_hz", line.rate_hz},
                     {"of", line.grasps},    {"all", coverage_json(line.found.all)}};
    for (const auto& [phase, tally] : line.found.by_phase) row["during"][phase] = coverage_json(tally);
    rows.push_back(std::move(row));
  }
  return result_of({{"grasps", options.setup.grasps}, {"noise", options.setup.noise}, {"too_safe", kTooSafe}},
                   std::move(rows));
}

void run(const offline::Common& common, CoverageOptions options) {
  options.setup.seed = common.seed;
  std::ostringstream traced;
  traced << kTracedHead;
  std::vector<CoverageLine> lines;
  for (const std::size_t side : options.sides) {
    for (const std::string& method : options.methods) {
      const auto found = measure_layout(side, method, options, common.out.empty() ? nullptr : &traced);
      lines.insert(lines.end(), found.begin(), found.end());
    }
  }
  publish({.print_table = [&] { print_table(lines, options); },
           .json = [&] { return to_sweep(lines, options); },
           .write_files =
               [&](const auto& folder) { offline::write_file(folder / "coverage.csv", traced.str()); }},
          common);
}

}  // namespace

void add_coverage(CLI::App& app, const offline::Common& common) {
  auto* command =
      app.add_subcommand("coverage", "whether margins lie within their sigmas, over whole grasps");
  auto options = std::make_shared<CoverageOptions>();
  add_grasps_option(*command, options->setup.grasps);
  add_sides_option(*command, options->sides);
  add_methods_option(*command, options->methods);
  command->add_option("--rates", options->rates_hz, "frames a second")
      ->delimiter(',')
      ->check(CLI::Range(10.0, 10000.0))
      ->capture_default_str();
  command->add_option("--of", options->grasps_of, "cycle, histories, holds")
      ->delimiter(',')
      ->check(CLI::IsMember({"cycle", "histories", "holds"}))
      ->capture_default_str();
  add_noise_option(*command, options->setup.noise);
  command->add_option("--friction", options->friction, "the estimator is given this coefficient of friction")
      ->check(CLI::Range(0.01, 10.0));
  add_threads_option(*command, options->setup.threads);
  command->callback([&common, options] { run(common, *options); });
}

}  // namespace lab
