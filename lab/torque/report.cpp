#include "lab/torque/report.hpp"

#include <cstdio>
#include <sstream>

#include "tools/offline/gnuplot.hpp"

namespace lab {
namespace {

using nlohmann::ordered_json;

// Single frames of force and torque: the error over the true margin, a panel for each layout and method.
void plot_points(const std::vector<TorqueLine>& lines, const std::filesystem::path& folder) {
  std::ostringstream data;
  std::vector<std::string> titles;
  for (const TorqueLine& line : lines) {
    if (line.course != Course::frame || line.mix == Mix::pull || line.points.empty()) continue;
    if (line.method != "fit" && line.method != "moments") continue;
    if (!titles.empty()) data << "\n\n";
    titles.push_back(std::to_string(line.side) + " x " + std::to_string(line.side) + ", " + line.method +
                     ", " + name_of(line.mix));
    for (const TurningPoint& at : line.points) data << at.truth << ' ' << at.gamma - at.truth << '\n';
  }
  if (titles.empty()) return;
  offline::write_file(folder / "torque.dat", data.str());
  std::ostringstream script;
  script << "set terminal svg size 900," << 170 * (titles.size() + 1) / 2
         << " font 'sans,12' background 'white'\nset output 'torque.svg'\nset multiplot layout "
         << (titles.size() + 1) / 2
         << ",2\nset grid\nset key left top\nset xrange [0:1]\nset yrange [-0.2:0.2]\n"
            "set ylabel 'error of Gamma'\n";
  for (std::size_t i = 0; i < titles.size(); ++i) {
    if (i + 2 >= titles.size()) script << "set xlabel 'Gamma'\n";
    script << "plot 'torque.dat' index " << i << " using 1:2 with points pt 7 ps 0.3 title '" << titles[i]
           << "'\n";
  }
  script << "unset multiplot\n";
  offline::plot(folder, "torque", script.str());
}

}  // namespace

void print_table(const std::vector<TorqueLine>& lines, const TorqueSetup& setup) {
  std::printf(
      "Contacts under force and torque: %zu single frames and %zu grasps a line, %g %% of sensor noise. Too "
      "safe: more than %g above the truth.\nFriction: at margins below 0.7, as learnt; off: by more than a "
      "tenth. Few taxels are given the friction.\n\n"
      "                             answered  below 0.7  mean err     bias  too safe  most above  1 sigma  2 "
      "sigma  "
      "friction    off   median us\n",
      setup.frames, setup.grasps, 100 * setup.noise, kTurningTooSafe);
  std::string last;
  for (const TorqueLine& line : lines) {
    const std::string title = std::to_string(line.side) + " x " + std::to_string(line.side);
    if (title != last) std::printf("%s%s\n", title.c_str(), line.friction_given ? ", friction given" : "");
    last = title;
    const TorqueTally& t = line.tally;
    std::printf(
        "  %-8s %-5s %-11s %6.1f %%   %6.1f %%   %.4f  %7.4f   %5.2f %%     %6.3f  %5.1f %%  %5.1f %%   %.4f "
        "%5.1f %%     %7.1f\n",
        name_of(line.course), name_of(line.mix), line.method.c_str(), 100 * t.margins.answered(),
        100 * t.near.answered(), t.margins.mean_error(), t.margins.bias(), 100 * t.margins.overestimated(),
        t.margins.most_above(), 100 * t.margins.within(1), 100 * t.margins.within(2), t.near.friction_error(),
        100 * t.near.friction_wrong(), t.taken_us.median());
  }
}

offline::SweepResult to_sweep(const std::vector<TorqueLine>& lines, const TorqueSetup& setup) {
  ordered_json rows = ordered_json::array();
  for (const TorqueLine& line : lines) {
    const TorqueTally& t = line.tally;
    rows.push_back({{"columns", line.side},
                    {"method", line.method},
                    {"used", line.used},
                    {"course", name_of(line.course)},
                    {"mix", name_of(line.mix)},
                    {"friction_given", line.friction_given},
                    {"answered", t.margins.answered()},
                    {"answered_below_0_7", t.near.answered()},
                    {"mean_error", t.margins.mean_error()},
                    {"bias", t.margins.bias()},
                    {"too_safe", t.margins.overestimated()},
                    {"most_above", t.margins.most_above()},
                    {"within_sigma", t.margins.within(1)},
                    {"within_two_sigma", t.margins.within(2)},
                    {"friction_error", t.near.friction_error()},
                    {"friction_wrong", t.near.friction_wrong()},
                    {"learning", t.margins.in_state(slipd::State::learning)},
                    {"out_of_model", t.margins.in_state(slipd::State::out_of_model)},
                    {"p50_us", t.taken_us.median()}});
  }
  return result_of({{"frames", setup.frames},
                    {"grasps", setup.grasps},
                    {"noise", setup.noise},
                    {"too_safe_above", kTurningTooSafe}},
                   std::move(rows));
}

void write_files(const std::vector<TorqueLine>& lines, const TorqueSetup& setup,
                 const std::filesystem::path& folder) {
  offline::write_file(
      folder / "torque.csv",
      to_csv(rows_of(to_sweep(lines, setup)),
             {"columns", "method", "course", "mix", "answered", "mean_error", "too_safe", "most_above",
              "within_sigma", "within_two_sigma", "friction_error", "friction_wrong", "p50_us"}));
  plot_points(lines, folder);
}

}  // namespace lab
