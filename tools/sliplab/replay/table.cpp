#include "tools/sliplab/replay/table.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <string>

#include "tools/offline/gnuplot.hpp"

namespace sliplab {
namespace {

using slipd::Alert;
using slipd::AlertCause;
using slipd::Estimate;

constexpr double kMmPerM = 1e3;
constexpr double kDegPerRad = 180 / std::numbers::pi;
constexpr double kFarOffRate = 3;        // factor
constexpr double kShortestStepS = 2e-9;  // longer than a step of which nothing is known, 1 ns

void put(std::ostringstream& out, std::optional<double> value, double factor = 1) {
  out << ',';
  if (value) out << factor * *value;
}

bool in_contact(const Estimate& estimate) {
  return estimate.contact.value_or(estimate.normal_n.has_value());
}

std::optional<double> rate_of(const std::vector<ReplayRow>& rows) {
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double step_s = rows[i].time_s - rows[i - 1].time_s;
    if (step_s > kShortestStepS) steps_s.push_back(step_s);
  }
  if (steps_s.empty()) return std::nullopt;
  const auto middle = steps_s.begin() + static_cast<std::ptrdiff_t>(steps_s.size() / 2);
  std::nth_element(steps_s.begin(), middle, steps_s.end());
  return 1 / *middle;
}

}  // namespace

std::string estimates_csv(const std::vector<ReplayRun>& runs) {
  std::ostringstream out;
  out.precision(9);
  out << "sensor,time_s,seq,state,gamma,gamma_low,sigma,friction,friction_sigma,normal_n,shear_n,torque_nmm,"
         "turned_deg,turned_sigma_deg,sliding,alert,alert_cause,displacement_mm,contact,slide_evidence\n";
  for (const ReplayRun& run : runs) {
    for (const ReplayRow& row : run.rows) {
      const Estimate& e = row.estimate;
      out << run.sensor << ',' << row.time_s << ',' << row.row << ',' << to_string(e.state);
      for (const auto& value :
           {e.gamma, e.gamma_low, e.sigma, e.friction, e.friction_sigma, e.normal_n, e.shear_n})
        put(out, value);
      put(out, e.torque_nm, kMmPerM);
      put(out, e.turned_rad, kDegPerRad);
      put(out, e.turned_sigma_rad, kDegPerRad);
      out << ',' << (e.sliding ? to_string(*e.sliding) : "") << ',' << to_string(e.alert) << ','
          << (e.alert_cause == AlertCause::none ? "" : to_string(e.alert_cause));
      put(out, e.displacement_m, kMmPerM);
      out << ',' << (e.contact ? std::to_string(int{*e.contact}) : "");
      put(out, e.slide_evidence);
      out << '\n';
    }
  }
  return out.str();
}

ReplaySummary summarize(const ReplayRun& run) {
  ReplaySummary summary;
  summary.rows = run.rows.size();
  summary.repeated = run.repeated;
  summary.unrisen = run.unrisen;
  summary.rate_hz = rate_of(run.rows);
  for (const ReplayRow& row : run.rows) {
    const Estimate& e = row.estimate;
    summary.contact += in_contact(e) ? 1 : 0;
    summary.with_margin += e.gamma ? 1 : 0;
    summary.sliding_rows += slides(e.sliding) ? 1 : 0;
    summary.disturbed_rows += e.sliding == slipd::Sliding::disturbed ? 1 : 0;
    if (e.gamma) summary.least_gamma = std::min(*e.gamma, summary.least_gamma.value_or(1));
    if (e.alert != Alert::slip) continue;
    ++summary.slip_rows;
    if (!summary.first_slip_s) summary.first_slip_s = row.time_s;
  }
  return summary;
}

nlohmann::json to_json(const ReplaySummary& s) {
  const auto known = [](std::optional<double> value) {
    return value ? nlohmann::json(*value) : nlohmann::json(nullptr);
  };
  return {{"rows", s.rows},
          {"contact_rows", s.contact},
          {"margin_rows", s.with_margin},
          {"slip_rows", s.slip_rows},
          {"sliding_rows", s.sliding_rows},
          {"disturbed_rows", s.disturbed_rows},
          {"repeated_rows", s.repeated},
          {"unrisen_rows", s.unrisen},
          {"rate_hz", known(s.rate_hz)},
          {"first_slip_s", known(s.first_slip_s)},
          {"least_gamma", known(s.least_gamma)}};
}

std::vector<std::string> remarks_on_time(const ReplayRun& run, const ReplaySummary& summary) {
  std::vector<std::string> remarks;
  if (summary.unrisen > 0)
    remarks.push_back("rows that are not later than the row before: " + std::to_string(summary.unrisen) +
                      ", each taken 1 ns after it: mend the file's times");
  if (!run.wanted_rate_hz || !(*run.wanted_rate_hz > 0) || !summary.rate_hz) return remarks;
  const double factor = *summary.rate_hz / *run.wanted_rate_hz;
  if (factor > 1 / kFarOffRate && factor < kFarOffRate) return remarks;
  std::ostringstream out;
  out.precision(3);
  out << "by their times " << *summary.rate_hz << " rows come a second, by rate_hz " << *run.wanted_rate_hz
      << ": correct rate_hz, or the file's times, which are in s";
  remarks.push_back(out.str());
  return remarks;
}

void draw(const std::vector<ReplayRun>& runs, const std::filesystem::path& svg) {
  const std::filesystem::path folder = svg.has_parent_path() ? svg.parent_path() : ".";
  const std::string name = svg.stem().string();
  std::ostringstream script;
  script << "set terminal svg size 900," << 260 * runs.size() << "\nset output '" << svg.filename().string()
         << "'\nset multiplot layout " << runs.size() << ",1\nset yrange [0:1.05]\nset xlabel 'time, s'\n"
         << "set datafile separator ','\nset key outside\n";
  for (std::size_t i = 0; i < runs.size(); ++i) {
    std::ostringstream csv;
    csv << "time_s,gamma,shear_over_normal,slip\n";
    for (const ReplayRow& row : runs[i].rows) {
      const Estimate& e = row.estimate;
      csv << row.time_s << ',' << e.gamma.value_or(slipd::kUnknown) << ',';
      csv << (e.normal_n && e.shear_n && *e.normal_n > 0 ? *e.shear_n / *e.normal_n : slipd::kUnknown);
      csv << ',' << (e.alert == Alert::slip ? 1 : 0) << '\n';
    }
    const std::string data = name + "-" + std::to_string(i) + ".csv";
    offline::write_file(folder / data, csv.str());
    script
        << "set title '" << runs[i].sensor << "' noenhanced\nplot '" << data
        << "' using 1:4 skip 1 with filledcurves y1=0 fs transparent solid 0.2 title 'alert slip', '' using "
           "1:2 skip 1 with lines title 'margin', '' using 1:3 skip 1 with lines title 'Q/P'\n";
  }
  offline::plot(folder, name, script.str());
}

}  // namespace sliplab
