#include "lab/alerts/report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/advice/alert.hpp"
#include "lab/tally/samples.hpp"
#include "tools/offline/gnuplot.hpp"

namespace lab {
namespace {

// An alert so long after the object began to slide still counts as soon, or so many frames, whichever is
// longer.
constexpr double kSoonS = 0.03;
constexpr double kSoonFrames = 3;
// Times are whole frames but for their rounding, s.
constexpr double kRoundingS = 1e-9;

// Holds with an alert, in an hour of holding.
double alerted_per_hour(const AlertLine& line) {
  return line.held_h > 0 ? static_cast<double>(line.holds_alerted) / line.held_h : 0;
}

double not_in_time(const AlertLine& line) {
  return percent(line.slips - line.soon, line.slips);
}

bool same_curve(const AlertLine& a, const AlertLine& b) {
  return a.preset == b.preset && a.friction_known == b.friction_known;
}

std::string said_of(const AlertLine& line) {
  return std::string(to_string(line.preset)) +
         (line.friction_known ? ", friction known" : ", friction 0.3–1");
}

}  // namespace

AlertLine count_alerts(const PresetBench& bench, bool friction_known, double cost,
                       const std::vector<AlertTrial>& holds, const std::vector<AlertTrial>& slips) {
  AlertLine line{.preset = bench.preset,
                 .rate_hz = bench.rate_hz,
                 .friction_known = friction_known,
                 .cost = cost,
                 .holds = holds.size(),
                 .slips = slips.size()};
  std::size_t contact = 0, answered = 0;
  for (const auto* const trials : {&holds, &slips}) {
    for (const AlertTrial& trial : *trials) {
      contact += trial.contact_frames;
      answered += trial.answered_frames;
    }
  }
  line.answered = contact > 0 ? static_cast<double>(answered) / static_cast<double>(contact) : 0;
  for (const AlertTrial& trial : holds) {
    line.holds_alerted += trial.first_alert_s ? 1 : 0;
    line.holds_slip += trial.first_slip_s ? 1 : 0;
    line.held_h += static_cast<double>(trial.contact_frames) / bench.rate_hz / 3600;
  }
  const double soon_s = std::max(kSoonS, kSoonFrames / bench.rate_hz);
  Samples delays_s, slid_m;
  for (const AlertTrial& trial : slips) {
    if (!trial.gross_slip_s || !trial.first_alert_s) {
      ++line.missed;
      continue;
    }
    const double delay_s = *trial.first_alert_s - *trial.gross_slip_s;
    delays_s.add(delay_s);
    line.before += delay_s < 0 ? 1 : 0;
    line.soon += delay_s <= soon_s + kRoundingS ? 1 : 0;
    if (delay_s >= 0 && trial.slid_m) slid_m.add(*trial.slid_m);
  }
  line.median_slid_m = slid_m.median();
  line.median_delay_s = delays_s.median();
  return line;
}

std::string alerts_table(const std::vector<AlertLine>& lines) {
  std::string text =
      "| preset | frames a second | friction | holds | with an alert | with `slip` | slips | alert before "
      "the slide | "
      "or within 30 ms or 3 frames | median alert, ms | slid until late alerts, mm | missed | coverage |\n"
      "|---|---:|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n";
  for (const AlertLine& line : lines) {
    std::array<char, 64> slid{};
    std::snprintf(slid.data(), slid.size(), "%.2f", 1e3 * line.median_slid_m);
    std::array<char, 300> row{};
    std::snprintf(row.data(), row.size(),
                  "| `%s` | %.0f | %s | %zu | %.1f %% | %.1f %% | %zu | %.1f %% | %.1f %% | %+.0f | %s | "
                  "%.1f %% | %.0f %% |\n",
                  std::string(to_string(line.preset)).c_str(), line.rate_hz,
                  line.friction_known ? "known" : "0.3–1", line.holds,
                  percent(line.holds_alerted, line.holds), percent(line.holds_slip, line.holds), line.slips,
                  percent(line.before, line.slips), percent(line.soon, line.slips), 1e3 * line.median_delay_s,
                  std::isfinite(line.median_slid_m) ? slid.data() : "–", percent(line.missed, line.slips),
                  100 * line.answered);
    text += row.data();
  }
  return text;
}

std::string costs_table(const std::vector<AlertLine>& lines) {
  std::string text =
      "| preset, friction | `cost` | sigmas taken off | holds with an alert | in an hour of holding | slips "
      "without "
      "one in time |\n|---|---:|---:|---:|---:|---:|\n";
  for (const AlertLine& line : lines) {
    std::array<char, 200> row{};
    std::snprintf(row.data(), row.size(), "| %s | %g | %.2f | %.1f %% | %.0f | %.1f %% |\n",
                  said_of(line).c_str(), line.cost, std::max(0.0, slipd::sigmas_for(line.cost)),
                  percent(line.holds_alerted, line.holds), alerted_per_hour(line), not_in_time(line));
    text += row.data();
  }
  return text;
}

void plot_costs(const std::vector<AlertLine>& lines, const std::filesystem::path& folder) {
  std::ostringstream data, curves;
  std::size_t index = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const AlertLine& line = lines[i];
    const bool first = i == 0 || !same_curve(line, lines[i - 1]);
    if (first && i > 0) data << "\n\n";
    index += first && i > 0 ? 1 : 0;
    data << alerted_per_hour(line) << ' ' << not_in_time(line) << ' ' << line.cost << '\n';
    if (!first) continue;
    curves << (i == 0 ? "plot " : ", ") << "'alert-cost.dat' index " << index
           << " using 1:2 with linespoints pt 7 ps 0.6 lc " << index + 1 << " title '" << said_of(line)
           << "', '' index " << index
           << " using 1:2:(sprintf('%g',$3)) with labels offset 0.5,0.7 left font ',10' notitle, '' index "
           << index << " using 1:($3 == " << slipd::AlertSettings{}.cost
           << " ? $2 : NaN) with points pt 6 ps 1.6 lw 2 lc " << index + 1 << " notitle";
  }
  offline::write_file(folder / "alert-cost.dat", data.str());
  offline::plot(folder, "alert-cost",
                "set terminal svg size 900,560 font 'sans,13' background 'white'\nset output "
                "'alert-cost.svg'\nset grid\n"
                "set key right top\nset logscale x\nset offsets graph 0, graph 0, graph 0.08, graph 0.04\n"
                "set xlabel 'held grasps with an alert, in an hour of holding'\nset ylabel 'slips without an "
                "alert in time, %'\n" +
                    curves.str() + "\n");
}

offline::SweepResult to_sweep(const std::vector<AlertLine>& lines) {
  auto rows = nlohmann::ordered_json::array();
  for (const AlertLine& line : lines) {
    rows.push_back({{"preset", to_string(line.preset)},
                    {"rate_hz", line.rate_hz},
                    {"friction_known", line.friction_known},
                    {"cost", line.cost},
                    {"held_h", line.held_h},
                    {"holds", line.holds},
                    {"holds_alerted", line.holds_alerted},
                    {"holds_slip", line.holds_slip},
                    {"slips", line.slips},
                    {"before", line.before},
                    {"soon", line.soon},
                    {"missed", line.missed},
                    {"median_delay_s", line.median_delay_s},
                    {"median_slid_m", line.median_slid_m},
                    {"answered", line.answered}});
  }
  return result_of(nlohmann::ordered_json::object(), std::move(rows));
}

}  // namespace lab
