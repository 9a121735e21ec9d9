#include "lab/alerts/report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "lab/tally/samples.hpp"

namespace lab {
namespace {

// An alert so long after the object began to slide still counts as soon, or so many frames, whichever is
// longer.
constexpr double kSoonS = 0.03;
constexpr double kSoonFrames = 3;
// Times are whole frames but for their rounding, s.
constexpr double kRoundingS = 1e-9;

}  // namespace

AlertLine count_alerts(const PresetBench& bench, bool friction_known, const std::vector<AlertTrial>& holds,
                       const std::vector<AlertTrial>& slips) {
  AlertLine line{.preset = bench.preset,
                 .rate_hz = bench.rate_hz,
                 .friction_known = friction_known,
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

offline::SweepResult to_sweep(const std::vector<AlertLine>& lines) {
  auto rows = nlohmann::ordered_json::array();
  for (const AlertLine& line : lines) {
    rows.push_back({{"preset", to_string(line.preset)},
                    {"rate_hz", line.rate_hz},
                    {"friction_known", line.friction_known},
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
