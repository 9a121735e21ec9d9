#include "lab/tradeoff/report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "lab/options.hpp"
#include "lab/report.hpp"
#include "tools/offline/gnuplot.hpp"

namespace lab {
namespace {

std::string title_of(const std::string& layout) {
  return layout == "wrench" ? "wrench" : layout + "x" + layout;
}

// "-" for a setting that the method does not have, and for an absent result.
std::string cell(double value, const char* form) {
  if (!std::isfinite(value)) return "-";
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), form, value);
  return text.data();
}
std::string cell(int setting) {
  return setting > 0 ? std::to_string(setting) : "-";
}

void print_head(const Line& line) {
  std::printf("\n%s, %s noise of %g %%.", title_of(line.layout).c_str(), name_of(line.noise.kind),
              100 * line.noise.half_width);
  if (std::isfinite(line.limit.mean_error))
    std::printf(" Cramer-Rao bound: %.4f, %.1f %% right.", line.limit.mean_error,
                100 * line.limit.class_correct);
  std::puts(
      "\n    method     rank rings   k  precision  memory kB  mean err   95 %      right  answered  1 sigma  "
      "2 sigma   p50 us   p99 us");
}

void print_line(const Line& line) {
  const auto& row = line.row;
  const auto& set = row.settings;
  std::printf(
      "  %c %-10s %4s %5s %3s  %-9s %10.1f  %8s  %8s  %5.1f %%  %5.1f %%  %5.1f %%  %5.1f %%  %7.1f  %7.1f  "
      "%s\n",
      line.front ? '*' : ' ', row.method.c_str(), cell(set.rank).c_str(), cell(set.rings).c_str(),
      cell(set.neighbours).c_str(), to_string(set.precision), 1e-3 * static_cast<double>(set.memory_bytes),
      cell(row.mean_error, "%.4f").c_str(), cell(row.p95_error, "%.4f").c_str(), 100 * row.right,
      100 * row.answered, 100 * row.within_sigma, 100 * row.within_two_sigma, row.p50_us, row.p99_us,
      line.when.c_str());
}

// A panel of the plot.
struct Panel {
  const char* layout;
  slipd::NoiseKind kind;
  double noise;
};
constexpr std::array<Panel, 6> kPanels{{{"100", slipd::NoiseKind::relative, 0.05},
                                        {"100", slipd::NoiseKind::sensor, 0.01},
                                        {"32", slipd::NoiseKind::relative, 0.01},
                                        {"16", slipd::NoiseKind::relative, 0.01},
                                        {"16", slipd::NoiseKind::sensor, 0.01},
                                        {"8", slipd::NoiseKind::relative, 0.01}}};

// The measured lines of a panel, from the fastest to the most accurate.
std::vector<const Line*> front_of(const std::vector<Line>& lines, const Panel& panel) {
  std::vector<const Line*> front;
  for (const auto& line : lines) {
    if (line.front && line.layout == panel.layout && line.noise.kind == panel.kind &&
        line.noise.half_width == panel.noise)
      front.push_back(&line);
  }
  std::sort(front.begin(), front.end(),
            [](const Line* one, const Line* two) { return one->row.p50_us < two->row.p50_us; });
  return front;
}

void write_fronts(const std::vector<Line>& lines, const std::filesystem::path& file) {
  std::ostringstream csv;
  csv << "layout,noise_kind,noise,p50_us,mean_error\n";
  for (const auto& panel : kPanels) {
    for (const Line* line : front_of(lines, panel)) {
      csv << line->layout << ',' << name_of(panel.kind) << ',' << panel.noise << ',' << line->row.p50_us
          << ',' << line->row.mean_error << '\n';
    }
  }
  offline::write_file(file, csv.str());
}

std::string script(const std::vector<Line>& lines) {
  std::ostringstream out;
  out << "set terminal svg size 1000,1200 font 'sans,12' background 'white'\nset output 'tradeoff.svg'\n"
         "set datafile separator ','\nset logscale xy\nset grid\nset format y '%g'\n"
         "set multiplot layout 3,2 margins 0.09,0.97,0.05,0.90 spacing 0.12,0.09\nmethods = 'moments "
         "block-fit fit "
         "registered svd-knn'\nset xlabel 'time per frame, us'\nset ylabel 'mean |error| of Gamma'\n"
         "set key at screen 0.5,0.995 center top horizontal maxrows 3 samplen 2 width -2\n";
  bool first = true;
  for (const auto& panel : kPanels) {
    if (front_of(lines, panel).empty()) continue;
    std::ostringstream pick;
    pick << "strcol(1) eq '" << panel.layout << "' && strcol(2) eq '" << name_of(panel.kind) << "' && abs($3-"
         << panel.noise << ")<1e-9";
    out << "set title '" << title_of(panel.layout) << ", " << name_of(panel.kind) << " noise "
        << 100 * panel.noise << " %'\nplot for [i=1:words(methods)] 'tradeoff.csv' using (" << pick.str()
        << " && strcol(5) eq word(methods,i) && strlen(strcol(4))==0 ? $16 : NaN):11 with points pt 2*i+3 lc "
           "i ps 0.8 title word(methods,i), "
        << "'tradeoff-front.csv' using (" << pick.str()
        << " ? $4 : NaN):5 with lines lc rgb 'black' title 'Pareto front', 'tradeoff.csv' using ("
        << pick.str() << " ? $16 : NaN):18 with lines dt 2 lc rgb '#7f8c8d' title 'theoretical bound'\n";
    if (first) out << "set key off\n";
    first = false;
  }
  out << "unset multiplot\n";
  return out.str();
}

}  // namespace

void print_table(const std::vector<Line>& lines, std::size_t contacts) {
  std::printf(
      "Error against run time: %zu contacts never trained on, up to 2 mm off the middle of a +-8 mm pad (4 x "
      "4: +-9.4 mm), Gamma\nuniform, loads rising, each frame for itself unless said otherwise, exact taxel "
      "averages; models trained at 1 %% of relative noise.\nTimes: per frame, patch included, processor time "
      "on %s.\n* nothing else is both faster and nearer to the truth.\n",
      contacts, slipd::processor_name().c_str());
  const Line* before = nullptr;
  for (const auto& line : lines) {
    if (before == nullptr || before->layout != line.layout || before->noise.kind != line.noise.kind ||
        before->noise.half_width != line.noise.half_width)
      print_head(line);
    print_line(line);
    before = &line;
  }
}

offline::SweepResult to_sweep(const std::vector<Line>& lines, std::size_t contacts) {
  offline::SweepResult sweep{{{"contacts", contacts}, {"processor", slipd::processor_name()}}, {}};
  for (const auto& line : lines) {
    const auto& row = line.row;
    const auto& set = row.settings;
    sweep.add_row(line.unit, {{"layout", line.layout},
                              {"noise_kind", name_of(line.noise.kind)},
                              {"noise", line.noise.half_width},
                              {"when", line.when},
                              {"method", row.method},
                              {"rank", set.rank},
                              {"rings", set.rings},
                              {"neighbours", set.neighbours},
                              {"precision", to_string(set.precision)},
                              {"memory_bytes", set.memory_bytes},
                              {"mean_error", row.mean_error},
                              {"p95_error", row.p95_error},
                              {"class_right", row.right},
                              {"answered", row.answered},
                              {"within_sigma", row.within_sigma},
                              {"within_two_sigma", row.within_two_sigma},
                              {"p50_us", row.p50_us},
                              {"p99_us", row.p99_us},
                              {"limit_error", line.limit.mean_error},
                              {"limit_right", line.limit.class_correct},
                              {"front", line.front}});
  }
  return sweep;
}

void write_files(const std::vector<Line>& lines, std::size_t contacts, const std::filesystem::path& folder) {
  offline::write_file(folder / "tradeoff.csv",
                      to_csv(rows_of(to_sweep(lines, contacts)),
                             {"layout",     "noise_kind", "noise",       "when",      "method",
                              "rank",       "rings",      "neighbours",  "precision", "memory_bytes",
                              "mean_error", "p95_error",  "class_right", "answered",  "within_two_sigma",
                              "p50_us",     "p99_us",     "limit_error", "front",     "within_sigma"}));
  write_fronts(lines, folder / "tradeoff-front.csv");
  offline::plot(folder, "tradeoff", script(lines));
}

}  // namespace lab
