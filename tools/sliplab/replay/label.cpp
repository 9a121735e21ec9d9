#include "tools/sliplab/replay/label.hpp"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tools/sliplab/command.hpp"

namespace sliplab {
namespace {

// An alert so long before a label still belongs to it, s; 0.1 … 2. Too small: early alerts are false ones.
// Too large: false ones are early.
constexpr double kEarliestS = 0.5;
constexpr double kSecondsPerHour = 3600;

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream in(line);
  for (std::string field; std::getline(in, field, ',');) {
    while (!field.empty() && (field.back() == '\r' || field.back() == ' ')) field.pop_back();
    fields.push_back(field);
  }
  return fields;
}

}  // namespace

std::vector<bool> read_labels(const std::filesystem::path& file, const ReplayRun& run) {
  std::ifstream in(file);
  std::string line;
  if (!in || !std::getline(in, line)) throw offline::WrongUse(file.string() + ": cannot be read");
  const auto names = fields_of(line);
  const auto column = static_cast<std::size_t>(std::find(names.begin(), names.end(), "slip") - names.begin());
  if (column == names.size()) throw offline::WrongUse(file.string() + ": line 1: no column slip");
  std::vector<bool> labels;
  while (std::getline(in, line)) {
    const auto fields = fields_of(line);
    if (fields.size() <= column)
      throw offline::WrongUse(file.string() + ": line " + std::to_string(labels.size() + 2) +
                              ": no field for slip");
    const std::string& field = fields[column];
    labels.push_back(field != "0" && field != "0.0");
  }
  if (labels.size() == 1) labels.assign(run.rows.size(), labels.front());
  if (labels.size() != run.rows.size()) {
    throw offline::WrongUse(file.string() + " has " + std::to_string(labels.size()) + " rows, " + run.file +
                            " has " + std::to_string(run.rows.size()) +
                            ": give one label for each row, or one for all");
  }
  return labels;
}

LabelScore score_alerts(const ReplayRun& run, const std::vector<bool>& labels) {
  LabelScore score;
  const auto first = std::find(labels.begin(), labels.end(), true);
  std::optional<double> label_s;
  if (first != labels.end()) label_s = run.rows[static_cast<std::size_t>(first - labels.begin())].time_s;
  std::optional<double> alert_s;
  bool was = false;
  for (std::size_t i = 0; i < run.rows.size(); ++i) {
    const ReplayRow& row = run.rows[i];
    if (!labels[i] && i > 0) score.unlabelled_s += row.time_s - run.rows[i - 1].time_s;
    const bool slip = row.estimate.alert == slipd::Alert::slip;
    if (slip && !was) {
      const bool early = !label_s || row.time_s < *label_s - kEarliestS;
      if (early) ++score.false_alerts;
      if (!early && !alert_s) alert_s = row.time_s;
    }
    was = slip;
  }
  if (label_s && alert_s) score.lead_s = *label_s - *alert_s;
  score.missed = label_s && !alert_s;
  return score;
}

nlohmann::json to_json(const LabelScore& score) {
  const double hours = score.unlabelled_s / kSecondsPerHour;
  return {{"lead_s", score.lead_s ? nlohmann::json(*score.lead_s) : nlohmann::json(nullptr)},
          {"missed", score.missed},
          {"false_alerts", score.false_alerts},
          {"false_per_hour", hours > 0 ? nlohmann::json(static_cast<double>(score.false_alerts) / hours)
                                       : nlohmann::json(nullptr)}};
}

std::string describe(const LabelScore& score) {
  std::ostringstream out;
  if (score.lead_s) {
    out << "the alert came " << std::abs(*score.lead_s) << " s " << (*score.lead_s < 0 ? "after" : "before")
        << " the label";
  } else {
    out << (score.missed ? "the labelled slip was missed" : "no slip is labelled");
  }
  out << "; false alerts: " << score.false_alerts << " in " << score.unlabelled_s << " s without a label";
  return out.str();
}

}  // namespace sliplab
