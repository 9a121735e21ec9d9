// Alerts of a replayed recording against labels.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/sliplab/replay/run.hpp"

namespace sliplab {

// Whether it slips in each row of the run: the column `slip` of a CSV with as many rows, 0 or 1. A recording
// that is labelled as a whole has one row. Throws WrongUse.
std::vector<bool> read_labels(const std::filesystem::path& file, const ReplayRun& run);

struct LabelScore {
  // From the first alert slip to the first labelled row, s; negative: the alert came after it.
  std::optional<double> lead_s;
  // A slip is labelled, and there was no alert.
  bool missed = false;
  // Alerts that began earlier than kEarliest before a label, or without one, and the time without a label.
  std::size_t false_alerts = 0;
  double unlabelled_s = 0;
};

LabelScore score_alerts(const ReplayRun& run, const std::vector<bool>& labels);
nlohmann::json to_json(const LabelScore& score);
std::string describe(const LabelScore& score);

}  // namespace sliplab
