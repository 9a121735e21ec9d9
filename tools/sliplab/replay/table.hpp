// What `sliplab replay` writes of its runs.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/sliplab/replay/run.hpp"

namespace sliplab {

// A line of column names, then a line for each row of each run; empty where a value is not known.
std::string estimates_csv(const std::vector<ReplayRun>& runs);

// Numbers of rows; times in s from the file's first row.
struct ReplaySummary {
  std::size_t rows = 0, contact = 0, with_margin = 0, slip_rows = 0, sliding_rows = 0, disturbed_rows = 0,
              repeated = 0, unrisen = 0;
  // Rows a second by the file's own times, by the median step; none: no time rises.
  std::optional<double> rate_hz;
  std::optional<double> first_slip_s;
  std::optional<double> least_gamma;
};
ReplaySummary summarize(const ReplayRun& run);
nlohmann::json to_json(const ReplaySummary& summary);

// What is wrong with the times of the file, a sentence each; none: they rise, at about the rate they should.
std::vector<std::string> remarks_on_time(const ReplayRun& run, const ReplaySummary& summary);

// Margin, Q/P and alerts of all runs over time, one below the other. Throws std::runtime_error.
void draw(const std::vector<ReplayRun>& runs, const std::filesystem::path& svg);

}  // namespace sliplab
