// What commands print and write: a table, JSON or CSV of the same rows.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "lab/tally/tally.hpp"
#include "tools/offline/sweep.hpp"

namespace lab {

// The results of one run of a command.
struct Report {
  std::function<void()> print_table;                                // on standard output
  std::function<offline::SweepResult()> json;                       // with --json, or of a shard
  std::function<void(const std::filesystem::path&)> write_files{};  // into the folder of --out; may be empty
};

// Prints and writes what the common options ask for. Throws std::runtime_error where a file cannot be
// written.
void publish(const Report& report, const offline::Common& common);
// The same of a command that can be measured in shards.
void publish(const Report& report, const offline::Common& common, const offline::Shard& shard,
             const CLI::App& command);

// Rows of one unit behind their head.
offline::SweepResult result_of(nlohmann::ordered_json head, nlohmann::ordered_json rows);

// The statistics of a tally that a row has, by their keys: frames, answered, answers, mean_error,
// worst_error, bias, class_right, claims_safer, claims_less_safe, within_sigma, within_two_sigma,
// within_three_sigma, low_above_truth, low_clearly_above_truth, low_worst, low_below_truth_by,
// friction_error, friction_wrong, the names of states for their shares, and states for all that occurred.
// Throws std::out_of_range for others.
nlohmann::ordered_json to_json(const Tally& tally, std::initializer_list<const char*> keys);

// Of 100; 0 of none.
inline double percent(std::size_t count, std::size_t all) {
  return all > 0 ? 100 * static_cast<double>(count) / static_cast<double>(all) : 0;
}

// A column of a CSV file and where its values stand in the rows, such as "all/mean_error"; by default under
// its name.
struct Column {
  Column(const char* column) : name(column), at(column) {}  // NOLINT(google-explicit-constructor)
  Column(const char* column, const char* place) : name(column), at(place) {}
  std::string name, at;
};
std::string to_csv(const std::vector<nlohmann::ordered_json>& rows, const std::vector<Column>& columns);
// Of all rows of a result.
std::vector<nlohmann::ordered_json> rows_of(const offline::SweepResult& result);

}  // namespace lab
