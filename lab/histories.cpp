// `slipd-lab histories`: the whole estimator chain over random grasps (regrip, unloading, reversal, slip,
// changes of friction), frame by frame against the truth. It measures what the estimator remembers from frame
// to frame.
#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "lab/collect.hpp"
#include "lab/command.hpp"
#include "lab/estimator.hpp"
#include "lab/frames/random_frames.hpp"
#include "lab/grasp/drive.hpp"
#include "lab/options.hpp"
#include "lab/report.hpp"
#include "tools/offline/gnuplot.hpp"
#include "tools/offline/progress.hpp"
#include "tools/offline/skin_base_name.hpp"
#include "tools/offline/sweep.hpp"

namespace lab {
namespace {

using namespace slipd;

// What the scene gives the estimator of a grasp's friction, which stays constant unless it is `none`.
enum class GivenFriction : std::uint8_t { none, constant, range, value };
const std::map<std::string, GivenFriction> kGiven{{"none", GivenFriction::none},
                                                  {"constant", GivenFriction::constant},
                                                  {"range", GivenFriction::range},
                                                  {"value", GivenFriction::value}};

struct HistoriesOptions {
  std::size_t grasps = 400;
  std::vector<std::size_t> sides{100, 16};
  std::vector<std::string> methods{"moments", "fit"};
  double skin_mm = 0;      // depth of the taxels
  double depth_taken = 1;  // the chain's, over that
  GivenFriction friction = GivenFriction::none;
  SkinBase base = SkinBase::half_space, base_taken = SkinBase::half_space;  // the true one, and the chain's
  Sampling sensing;
  unsigned threads = 2;
  offline::Shard shard;  // of sides and methods
};

const std::map<std::string, SkinBase> kBases{{offline::name_of(SkinBase::half_space), SkinBase::half_space},
                                             {offline::name_of(SkinBase::rigid), SkinBase::rigid}};

using TalliesByMove = std::array<Tally, kMoves>;

struct MethodLine {
  std::size_t side = 0;
  std::string method;
  Tally all;
  TalliesByMove by_move{};
  std::size_t unit = 0;  // number of its side and method in the sweep
};

Grasp with_one_friction(Grasp grasp) {
  for (LoadSegment& segment : grasp.segments) segment.friction = grasp.contact.friction;
  return grasp;
}

// A range that the friction lies anywhere in, by the grasp's number.
std::optional<KnownFriction> given_friction(double friction, GivenFriction given, std::size_t grasp) {
  constexpr double kWidth = 1.6;  // high over low
  if (given == GivenFriction::none || given == GivenFriction::constant) return std::nullopt;
  if (given == GivenFriction::value) return KnownFriction(friction);
  const double low = friction / std::pow(kWidth, RandomStream(0x746f6c64).uniform(grasp));
  return KnownFriction(Range{low, kWidth * low});
}

void write_traced(std::ostream& out, const GraspSample& sample) {
  const GraspMoment& at = sample.at;
  const Estimate& estimate = sample.estimate();
  out << at.time_s << ',' << name_of(static_cast<Move>(at.move)) << ',' << at.normal_n << ',' << at.shear_n
      << ',' << at.truth.gamma << ',' << estimate.gamma.value_or(kUnknown) << ','
      << estimate.sigma.value_or(kUnknown) << ',' << to_string(estimate.state) << '\n';
}

MethodLine measure(std::size_t side, const std::string& method, const HistoriesOptions& options,
                   std::uint64_t seed, std::string& trace) {
  ChainSetup setup = paper_chain(side, method_choices().at(method), options.sensing.noise);
  setup.scene.skin.depth_m = 1e-3 * options.skin_mm;
  Skin felt = setup.scene.skin;
  felt.base = options.base;
  setup.scene.skin.base = options.base_taken;
  setup.scene.skin.depth_m *= options.depth_taken;
  const Estimator estimator = make_estimator(setup, options.threads);
  offline::ProgressBar bar(title_of(side, method));
  std::ostringstream traced;
  traced << "time_s,move,normal_n,shear_n,truth,gamma,sigma,state\n";
  const auto play = [&](std::size_t i) {
    Grasp grasp = draw_grasp(setup.scene, seed, i);
    if (options.friction != GivenFriction::none) grasp = with_one_friction(std::move(grasp));
    ChainSetup scene = setup;
    scene.friction = given_friction(grasp.contact.friction, options.friction, i);
    EstimatorChain chain(scene, estimator.model);
    RandomFrames frames(std::move(grasp), setup.layout, felt, options.sensing, RandomStream(seed).stream(i));
    TalliesByMove tallies;
    drive(frames, chain, [&](const GraspSample& sample) {
      tallies.at(sample.at.move).add(sample.estimate(), sample.at.truth);
      if (i == 0) write_traced(traced, sample);
    });
    return tallies;
  };
  MethodLine line{.side = side, .method = method, .all = Tally{}};
  for (const TalliesByMove& grasp : collect(
           options.grasps, options.threads, [&](double share) { bar.show(share, "grasps"); }, play)) {
    for (std::size_t move = 0; move < kMoves; ++move) {
      line.by_move[move].add(grasp[move]);
      if (move != static_cast<std::size_t>(Move::unseen)) line.all.add(grasp[move]);
    }
  }
  trace = traced.str();
  return line;
}

void print_row(const std::string& what, const Tally& tally) {
  std::printf(
      "  %-12s %8.0f   %5.1f %%   %.4f   %5.1f %%  %6.2f %%  %6.2f %%  %5.1f %%  %5.1f %%  %.2f   %5.2f %%  "
      "%.2f  %.3f\n",
      what.c_str(), tally.frames(), 100 * tally.answered(), tally.mean_error(), 100 * tally.class_correct(),
      100 * tally.overestimated(), 100 * tally.underestimated(), 100 * tally.within(1), 100 * tally.within(2),
      tally.worst(), 100 * tally.low_above(), tally.low_worst(), tally.low_shortfall());
}

void print_table(const std::vector<MethodLine>& lines, const HistoriesOptions& options) {
  std::printf(
      "Random grasps, %zu of each kind: contacts as the paper's, up to 2 mm off the middle of a +-8 mm pad, "
      "gripped, loaded, then\neight moves drawn at random; a frame each %g ms; noise %g %% (%s). Safer, less "
      "safe: answers off by more than %g.\n\n"
      "  during         frames  answered  mean err   right    safer   less safe  1 sigma  2 sigma  worst  "
      "low above   most  low below\n",
      options.grasps, 1e3 * options.sensing.frame_s, 100 * options.sensing.noise,
      name_of(options.sensing.kind), kGrossError);
  for (const auto& line : lines) {
    std::printf("%zu x %zu, %s\n", line.side, line.side, line.method.c_str());
    print_row("everything", line.all);
    for (std::size_t move = 0; move < kMoves; ++move)
      print_row(std::string(name_of(static_cast<Move>(move))), line.by_move[move]);
  }
}

nlohmann::ordered_json as_json(const Tally& tally) {
  return to_json(tally, {"frames", "answered", "mean_error", "worst_error", "class_right", "claims_safer",
                         "claims_less_safe", "within_sigma", "within_two_sigma", "low_above_truth",
                         "low_worst", "low_below_truth_by", "states"});
}

offline::SweepResult to_sweep(const std::vector<MethodLine>& lines, const HistoriesOptions& options) {
  offline::SweepResult sweep{{{"grasps", options.grasps},
                              {"noise_kind", name_of(options.sensing.kind)},
                              {"noise", options.sensing.noise},
                              {"skin_mm", options.skin_mm},
                              {"depth_taken", options.depth_taken},
                              {"axes", options.sensing.stretch},
                              {"power", options.sensing.power},
                              {"base", offline::name_of(options.base)},
                              {"base_taken", offline::name_of(options.base_taken)},
                              {"frame_ms", 1e3 * options.sensing.frame_s}},
                             {}};
  for (const auto& line : lines) {
    nlohmann::ordered_json row{{"columns", line.side}, {"method", line.method}, {"all", as_json(line.all)}};
    for (std::size_t move = 0; move < kMoves; ++move)
      row["during"][std::string(name_of(static_cast<Move>(move)))] = as_json(line.by_move[move]);
    sweep.add_row(line.unit, std::move(row));
  }
  return sweep;
}

void write_table(const std::vector<MethodLine>& lines, const std::filesystem::path& folder) {
  std::vector<nlohmann::ordered_json> rows;
  const auto add = [&](const MethodLine& line, std::string_view during, const Tally& tally) {
    rows.push_back({{"columns", line.side}, {"method", line.method}, {"during", during}});
    rows.back().update(as_json(tally));
  };
  for (const auto& line : lines) {
    add(line, "everything", line.all);
    for (std::size_t move = 0; move < kMoves; ++move)
      add(line, name_of(static_cast<Move>(move)), line.by_move[move]);
  }
  offline::write_file(
      folder / "histories.csv",
      to_csv(rows, {"columns", "method", "during", "frames", "answered", "mean_error", "worst_error",
                    "class_right", "claims_safer", "claims_less_safe", "within_sigma", "within_two_sigma"}));
}

// Plots the first grasp of each line.
void plot_traces(const std::filesystem::path& folder, const std::vector<MethodLine>& lines) {
  std::ostringstream script;
  script << "set terminal svg size 900," << 60 + 220 * lines.size()
         << " font 'sans,12' background 'white'\nset output 'histories.svg'\nset datafile separator ','\n"
            "set multiplot layout "
         << lines.size() << ",1\nset yrange [-0.05:1.05]\nset ylabel 'safety margin'\nset grid\n"
         << "set style fill transparent solid 0.25 noborder\nset key outside right top\n";
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (i + 1 == lines.size()) script << "set xlabel 'time, s'\n";
    const std::string name = lines[i].method + "-" + std::to_string(lines[i].side);
    script << "set title '" << lines[i].side << " x " << lines[i].side << ", " << lines[i].method
           << "'\nplot 'grasp-" << name
           << ".csv' using 1:($6-2*$7):($6+2*$7) with filledcurves lc rgb '#4a90d9' title '2 sigma', "
              "'' using 1:6 with lines lc rgb '#1f4e8c' lw 1.5 title 'estimated', "
              "'' using 1:5 with lines lc rgb 'black' dt 2 title 'true'\n";
  }
  script << "unset multiplot\n";
  offline::plot(folder, "histories", script.str());
}

void run(const offline::Common& common, const CLI::App& command, const HistoriesOptions& options) {
  offline::refuse_files(options.shard, common);
  if (!common.out.empty()) std::filesystem::create_directories(common.out);
  std::vector<MethodLine> lines;
  std::size_t unit = 0;
  for (const std::size_t side : options.sides) {
    for (const auto& method : options.methods) {
      if (!options.shard.has(unit++)) continue;
      std::string trace;
      lines.push_back(measure(side, method, options, common.seed, trace));
      lines.back().unit = unit - 1;
      if (!common.out.empty())
        offline::write_file(common.out / ("grasp-" + method + "-" + std::to_string(side) + ".csv"), trace);
    }
  }
  publish({.print_table = [&] { print_table(lines, options); },
           .json = [&] { return to_sweep(lines, options); },
           .write_files =
               [&](const auto& folder) {
                 write_table(lines, folder);
                 plot_traces(folder, lines);
               }},
          common, options.shard, command);
}

}  // namespace

void add_histories(CLI::App& app, const offline::Common& common) {
  auto* command =
      app.add_subcommand("histories", "measure the whole chain on random grasps against the truth");
  auto options = std::make_shared<HistoriesOptions>();
  add_grasps_option(*command, options->grasps, "grasps for each layout and method");
  add_sides_option(*command, options->sides);
  add_methods_option(*command, options->methods);
  add_noise_options(*command, options->sensing.noise, options->sensing.kind);
  command->add_option("--skin-mm", options->skin_mm, "depth of the taxels under the surface, known, mm")
      ->check(CLI::Range(0.0, 5.0))
      ->capture_default_str();
  command
      ->add_option("--depth-taken", options->depth_taken,
                   "depth that the scene gives, divided by the true one")
      ->check(CLI::Range(0.2, 5.0))
      ->capture_default_str();
  command
      ->add_option(
          "--friction", options->friction,
          "what the scene gives of friction: none; of a friction that stays constant, constant gives "
          "nothing, range a range a factor of 1.6 wide, and value itself")
      ->transform(CLI::CheckedTransformer(kGiven, CLI::ignore_case))
      ->default_str("none");
  command
      ->add_option("--axes", options->sensing.stretch,
                   "long over short axis of the contact, which lies in any direction to the pull")
      ->check(CLI::Range(1.0, 3.0))
      ->capture_default_str();
  command
      ->add_option("--power", options->sensing.power,
                   "n of an object whose gap grows as r^n: 2 is a sphere, 8 is nearly flat")
      ->check(CLI::Range(2.0, 8.0))
      ->capture_default_str();
  const auto add_base = [&](const char* option, SkinBase& base, const char* about) {
    command->add_option(option, base, about)
        ->transform(CLI::CheckedTransformer(kBases, CLI::ignore_case))
        ->default_str("half_space");
  };
  add_base("--base", options->base, "what the skin lies on, see skin.base in slipd.json(5)");
  add_base("--base-taken", options->base_taken, "what the method takes it to lie on");
  add_frame_option(*command, options->sensing.frame_s);
  add_threads_option(*command, options->threads);
  offline::add_shard_option(*command, options->shard);
  command->callback([&common, command, options] { run(common, *command, *options); });
}

}  // namespace lab
