#include "lab/histories/report.hpp"

#include <cstdio>
#include <sstream>
#include <string>
#include <string_view>

#include "lab/options.hpp"
#include "tools/offline/gnuplot.hpp"

namespace lab {
namespace {

void print_row(const std::string& what, const Tally& tally) {
  std::printf(
      "  %-12s %8.0f   %5.1f %%   %.4f   %5.1f %%  %6.2f %%  %6.2f %%  %5.1f %%  %5.1f %%  %.2f   %5.2f %%  "
      "%.2f  %.3f\n",
      what.c_str(), tally.frames(), 100 * tally.answered(), tally.mean_error(), 100 * tally.class_correct(),
      100 * tally.overestimated(), 100 * tally.underestimated(), 100 * tally.within(1), 100 * tally.within(2),
      tally.worst(), 100 * tally.low_above(), tally.low_worst(), tally.low_shortfall());
}

nlohmann::ordered_json as_json(const Tally& tally) {
  return to_json(tally, {"frames", "answered", "mean_error", "worst_error", "class_right", "claims_safer",
                         "claims_less_safe", "within_sigma", "within_two_sigma", "low_above_truth",
                         "low_clearly_above_truth", "low_worst", "low_below_truth_by", "states"});
}

void write_table(const std::vector<HistoriesLine>& lines, const std::filesystem::path& folder) {
  std::vector<nlohmann::ordered_json> rows;
  const auto add = [&](const HistoriesLine& line, std::string_view during, const Tally& tally) {
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
void plot_traces(const std::filesystem::path& folder, const std::vector<HistoriesLine>& lines) {
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

}  // namespace

void print_table(const std::vector<HistoriesLine>& lines, const HistoriesSetup& setup) {
  std::printf(
      "Random grasps, %zu of each kind: contacts as the paper's, up to 2 mm off the middle of a +-8 mm pad, "
      "gripped, loaded, then\neight moves drawn at random; a frame each %g ms; noise %g %% (%s). Safer, less "
      "safe: answers off by more than %g.\n\n"
      "  during         frames  answered  mean err   right    safer   less safe  1 sigma  2 sigma  worst  "
      "low above   most  low below\n",
      setup.grasps, 1e3 * setup.sensing.frame_s, 100 * setup.sensing.noise, name_of(setup.sensing.kind),
      kGrossError);
  for (const auto& line : lines) {
    std::printf("%zu x %zu, %s\n", line.side, line.side, line.method.c_str());
    print_row("everything", line.all);
    std::printf(
        "  gamma_low above the truth %.2f %% +- %.2f, by more than %g %.2f %% +- %.2f (standard deviations "
        "over grasps)\n",
        100 * line.low_above.share(), 100 * line.low_above.sigma(), kClearlyAbove,
        100 * line.low_clearly_above.share(), 100 * line.low_clearly_above.sigma());
    for (std::size_t move = 0; move < kMoves; ++move)
      print_row(std::string(name_of(static_cast<Move>(move))), line.by_move[move]);
  }
}

offline::SweepResult to_sweep(const std::vector<HistoriesLine>& lines, const HistoriesSetup& setup) {
  offline::SweepResult sweep{{{"grasps", setup.grasps},
                              {"noise_kind", name_of(setup.sensing.kind)},
                              {"noise", setup.sensing.noise},
                              {"skin_mm", setup.skin_mm},
                              {"depth_taken", setup.depth_taken},
                              {"axes", setup.sensing.stretch},
                              {"power", setup.sensing.power},
                              {"base", slipd::to_string(setup.base)},
                              {"base_taken", slipd::to_string(setup.base_taken)},
                              {"frame_ms", 1e3 * setup.sensing.frame_s}},
                             {}};
  for (const auto& line : lines) {
    nlohmann::ordered_json row{{"columns", line.side}, {"method", line.method}, {"all", as_json(line.all)}};
    row["all"]["low_above_truth_sigma"] = line.low_above.sigma();
    row["all"]["low_clearly_above_truth_sigma"] = line.low_clearly_above.sigma();
    for (std::size_t move = 0; move < kMoves; ++move)
      row["during"][std::string(name_of(static_cast<Move>(move)))] = as_json(line.by_move[move]);
    sweep.add_row(line.unit, std::move(row));
  }
  return sweep;
}

void write_files(const std::vector<HistoriesLine>& lines, const std::filesystem::path& folder) {
  for (const HistoriesLine& line : lines)
    offline::write_file(folder / ("grasp-" + line.method + "-" + std::to_string(line.side) + ".csv"),
                        line.first_grasp);
  write_table(lines, folder);
  plot_traces(folder, lines);
}

}  // namespace lab
