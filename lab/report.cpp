#include "lab/report.hpp"

#include <CLI/CLI.hpp>
#include <map>
#include <sstream>
#include <string_view>
#include <utility>

namespace lab {
namespace {

using nlohmann::ordered_json;
using slipd::State;

ordered_json states_of(const Tally& tally) {
  ordered_json states = ordered_json::object();
  for (std::size_t i = 0; i < Tally::kStates; ++i) {
    const auto state = static_cast<State>(i);
    if (tally.in_state(state) > 0) states[std::string(to_string(state))] = tally.in_state(state);
  }
  return states;
}

using Statistic = ordered_json (*)(const Tally&);
const std::map<std::string_view, Statistic> kStatistics{
    {"frames", [](const Tally& t) -> ordered_json { return t.frames(); }},
    {"answered", [](const Tally& t) -> ordered_json { return t.answered(); }},
    {"answers", [](const Tally& t) -> ordered_json { return t.answers(); }},
    {"mean_error", [](const Tally& t) -> ordered_json { return t.mean_error(); }},
    {"worst_error", [](const Tally& t) -> ordered_json { return t.worst(); }},
    {"bias", [](const Tally& t) -> ordered_json { return t.bias(); }},
    {"class_right", [](const Tally& t) -> ordered_json { return t.class_correct(); }},
    {"claims_safer", [](const Tally& t) -> ordered_json { return t.overestimated(); }},
    {"claims_less_safe", [](const Tally& t) -> ordered_json { return t.underestimated(); }},
    {"within_sigma", [](const Tally& t) -> ordered_json { return t.within(1); }},
    {"within_two_sigma", [](const Tally& t) -> ordered_json { return t.within(2); }},
    {"within_three_sigma", [](const Tally& t) -> ordered_json { return t.within(3); }},
    {"low_above_truth", [](const Tally& t) -> ordered_json { return t.low_above(); }},
    {"low_worst", [](const Tally& t) -> ordered_json { return t.low_worst(); }},
    {"low_clearly_above_truth", [](const Tally& t) -> ordered_json { return t.low_clearly_above(); }},
    {"low_below_truth_by", [](const Tally& t) -> ordered_json { return t.low_shortfall(); }},
    {"friction_error", [](const Tally& t) -> ordered_json { return t.friction_error(); }},
    {"friction_wrong", [](const Tally& t) -> ordered_json { return t.friction_wrong(); }},
    {"no_contact", [](const Tally& t) -> ordered_json { return t.in_state(State::no_contact); }},
    {"learning", [](const Tally& t) -> ordered_json { return t.in_state(State::learning); }},
    {"out_of_model", [](const Tally& t) -> ordered_json { return t.in_state(State::out_of_model); }},
    {"states", states_of}};

void write(std::ostream& out, const ordered_json& value) {
  if (value.is_string()) {
    out << value.get_ref<const std::string&>();
  } else if (value.is_boolean()) {
    out << value.get<bool>();
  } else if (value.is_number_float()) {
    out << value.get<double>();
  } else {
    out << value;
  }
}

}  // namespace

void publish(const Report& report, const offline::Common& common, const offline::Shard& shard,
             const CLI::App& command) {
  if (common.json || !shard.whole()) {
    offline::print_json(report.json(), shard, common, command);
  } else {
    report.print_table();
  }
  if (common.out.empty() || !report.write_files) return;
  std::filesystem::create_directories(common.out);
  report.write_files(common.out);
}

void publish(const Report& report, const offline::Common& common) {
  publish(report, common, offline::Shard{}, CLI::App{});
}

offline::SweepResult result_of(ordered_json head, ordered_json rows) {
  offline::SweepResult result{std::move(head), {}};
  result.units.push_back({0, std::move(rows)});
  return result;
}

ordered_json to_json(const Tally& tally, std::initializer_list<const char*> keys) {
  ordered_json row = ordered_json::object();
  for (const char* key : keys) row[key] = kStatistics.at(key)(tally);
  return row;
}

std::vector<ordered_json> rows_of(const offline::SweepResult& result) {
  std::vector<ordered_json> rows;
  for (const offline::UnitResult& unit : result.units)
    rows.insert(rows.end(), unit.value.begin(), unit.value.end());
  return rows;
}

std::string to_csv(const std::vector<ordered_json>& rows, const std::vector<Column>& columns) {
  std::ostringstream csv;
  for (const Column& column : columns) csv << (&column == columns.data() ? "" : ",") << column.name;
  csv << '\n';
  for (const ordered_json& row : rows) {
    for (const Column& column : columns) {
      if (&column != columns.data()) csv << ',';
      write(csv, row.at(ordered_json::json_pointer("/" + column.at)));
    }
    csv << '\n';
  }
  return csv.str();
}

}  // namespace lab
