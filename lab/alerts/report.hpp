// What `slipd-lab alerts` writes: one line for each preset, and friction known or not.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lab/alerts/trial.hpp"
#include "lab/report.hpp"

namespace lab {

struct AlertLine {
  slipd::sim::Preset preset = slipd::sim::Preset::ideal;
  double rate_hz = 0;
  bool friction_known = false;
  double cost = 0;  // AlertSettings::cost
  std::size_t holds = 0;
  std::size_t holds_alerted = 0;  // with an alert of any level
  std::size_t holds_slip = 0;     // with level slip
  std::size_t slips = 0;
  std::size_t before = 0;     // slips with an alert of any level before the object slid
  std::size_t soon = 0;       // before, or within 30 ms or three frames after
  std::size_t missed = 0;     // slips without an alert, or before the load began to rise
  double median_delay_s = 0;  // of the others, after the object began to slide; below 0: before
  double median_slid_m = 0;   // of the alerts after it, how far the object had slid
  double answered = 0;        // share of frames in contact with a margin, of holds and slips
  double held_h = 0;          // how long all holds lasted together, h
};

// Counts the trials of one line. `slips` and `holds` are of the kinds of that name.
AlertLine count_alerts(const PresetBench& bench, bool friction_known, double cost,
                       const std::vector<AlertTrial>& holds, const std::vector<AlertTrial>& slips);

// Tables in Markdown: of lines of one cost; and of what each cost chooses, holds with an alert in an hour of
// holding against slips without one in time.
std::string alerts_table(const std::vector<AlertLine>& lines);
std::string costs_table(const std::vector<AlertLine>& lines);
// alert-cost.svg: a curve for each preset, its costs as points. Throws std::runtime_error where it cannot.
void plot_costs(const std::vector<AlertLine>& lines, const std::filesystem::path& folder);
offline::SweepResult to_sweep(const std::vector<AlertLine>& lines);

}  // namespace lab
