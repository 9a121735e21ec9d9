#include "lab/overload/report.hpp"

#include <cstdio>
#include <sstream>

#include "lab/options.hpp"
#include "tools/offline/gnuplot.hpp"

namespace lab {
namespace {

using nlohmann::ordered_json;

bool same_estimator(const OverloadLine& a, const OverloadLine& b) {
  return a.columns == b.columns && a.method == b.method;
}

ordered_json statistics_of(const Tally& tally) {
  return to_json(tally,
                 {"frames", "answered", "mean_error", "worst_error", "claims_safer", "claims_less_safe",
                  "within_sigma", "within_two_sigma", "within_three_sigma", "states"});
}

// Of the lines with a frame at regular intervals: what one more estimator's curve is drawn from.
void plot_curves(const std::vector<OverloadLine>& lines, const std::filesystem::path& folder) {
  std::ostringstream data;
  std::vector<std::string> titles;
  const OverloadLine* last = nullptr;
  for (const auto& line : lines) {
    if (line.skipped.skipping != Skipping::regular) continue;
    if (last == nullptr || !same_estimator(*last, line)) {
      if (last != nullptr) data << "\n\n";
      titles.push_back(std::to_string(line.columns) + " x " + std::to_string(line.columns) + ", " +
                       line.method);
    }
    last = &line;
    const Tally& t = line.estimates;
    data << line.skipped.k << ' ' << t.mean_error() << ' ' << 100 * t.answered() << ' ' << 100 * t.within(2)
         << ' ' << 100 * t.overestimated() << '\n';
  }
  offline::write_file(folder / "overload.dat", data.str());
  std::ostringstream script;
  script << "set terminal svg size 900,1000 font 'sans,12' background 'white'\nset output 'overload.svg'\n"
            "set multiplot layout 4,1\nset logscale x\nset xtics (1,2,5,10,20,50)\nset xrange [0.9:55]\n"
            "set grid\nset lmargin 10\nset rmargin 28\nset key outside right top\n";
  const std::vector<const char*> quantities{"mean error", "coverage, %", "within 2 sigma, %",
                                            "overestimates, %"};
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    script << "set ylabel '" << quantities[q] << "'\n";
    if (q + 1 == quantities.size()) script << "set xlabel 'one frame of k comes'\n";
    for (std::size_t i = 0; i < titles.size(); ++i)
      script << (i == 0 ? "plot 'overload.dat'" : ", ''") << " index " << i << " using 1:" << q + 2
             << " with linespoints title '" << titles[i] << '\'';
    script << (q == 0 ? "\nset key off\n" : "\n");
  }
  script << "unset multiplot\n";
  if (!titles.empty()) offline::plot(folder, "overload", script.str());
}

}  // namespace

void print_table(const std::vector<OverloadLine>& lines, const OverloadSetup& setup) {
  std::printf(
      "Random grasps, %zu a line, of a sensor with a frame each %g ms; 1/k of the frames come, regularly, at "
      "random, or in bursts.\nSafer, less safe: answers off by more than %g. On the board: what the last "
      "estimate says, at every frame of the sensor.\n\n"
      "                               of the frames that come                                              "
      "       on the board\n"
      "  k   frames come    answered  mean err   safer  less safe  1 sigma  2 sigma  3 sigma  learning  out "
      "of "
      "model   mean err   safer\n",
      setup.grasps, 1e3 * setup.sensing.frame_s, kGrossError);
  const OverloadLine* last = nullptr;
  for (const auto& line : lines) {
    if (last == nullptr || !same_estimator(*last, line))
      std::printf("%zu x %zu, %s\n", line.columns, line.columns, line.method.c_str());
    last = &line;
    const Tally& t = line.estimates;
    std::printf(
        "%3u   %-12s  %6.1f %%   %.4f  %6.2f %%   %5.2f %%  %5.1f %%  %5.1f %%  %5.1f %%   %5.1f %%  "
        "     %5.1f %%     %.4f  %6.2f %%\n",
        line.skipped.k, std::string(name_of(line.skipped.skipping)).c_str(), 100 * t.answered(),
        t.mean_error(), 100 * t.overestimated(), 100 * t.underestimated(), 100 * t.within(1),
        100 * t.within(2), 100 * t.within(3), 100 * t.in_state(slipd::State::learning),
        100 * t.in_state(slipd::State::out_of_model), line.board.mean_error(),
        100 * line.board.overestimated());
  }
}

offline::SweepResult to_sweep(const std::vector<OverloadLine>& lines, const OverloadSetup& setup) {
  ordered_json rows = ordered_json::array();
  for (const auto& line : lines) {
    rows.push_back({{"columns", line.columns},
                    {"method", line.method},
                    {"frames_come", name_of(line.skipped.skipping)},
                    {"k", line.skipped.k},
                    {"estimates", statistics_of(line.estimates)},
                    {"board", statistics_of(line.board)}});
  }
  return result_of({{"grasps", setup.grasps},
                    {"noise", setup.sensing.noise},
                    {"noise_kind", name_of(setup.sensing.kind)},
                    {"frame_ms", 1e3 * setup.sensing.frame_s}},
                   std::move(rows));
}

void write_files(const std::vector<OverloadLine>& lines, const OverloadSetup& setup,
                 const std::filesystem::path& folder) {
  offline::write_file(folder / "overload.csv", to_csv(rows_of(to_sweep(lines, setup)),
                                                      {"columns",
                                                       "method",
                                                       "frames_come",
                                                       "k",
                                                       {"answered", "estimates/answered"},
                                                       {"mean_error", "estimates/mean_error"},
                                                       {"claims_safer", "estimates/claims_safer"},
                                                       {"claims_less_safe", "estimates/claims_less_safe"},
                                                       {"within_sigma", "estimates/within_sigma"},
                                                       {"within_two_sigma", "estimates/within_two_sigma"},
                                                       {"within_three_sigma", "estimates/within_three_sigma"},
                                                       {"board_mean_error", "board/mean_error"},
                                                       {"board_claims_safer", "board/claims_safer"}}));
  plot_curves(lines, folder);
}

}  // namespace lab
