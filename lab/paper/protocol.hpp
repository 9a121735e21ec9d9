// The rows of the paper's table: the experiments, and their results over the seeds.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "lab/paper/experiment.hpp"

namespace lab {

struct ProtocolOptions {
  bool fast = false;  // a small grid and few contacts: a functional test without meaningful figures
  int seeds = 5;      // repetitions, each with its own seed
  std::uint64_t first_seed = 1;  // the others follow it
  unsigned threads = 2;
};

// One experiment, repeated with the contacts, the noise and the split of each seed.
struct Row {
  std::string title;              // for people
  Experiment experiment;          // of the first seed
  std::vector<Outcome> outcomes;  // one per seed
};

// One figure over the seeds, a share of 0 … 1.
struct Spread {
  double mean = 0;
  double low = 0;   // smallest
  double high = 0;  // largest
};
Spread spread_of(const Row& row, const std::function<double(const Outcome&)>& figure);

// The share of variance that the first `bases` explain together.
double explained(const Outcome& outcome, std::size_t bases);

std::vector<Experiment> protocol(const ProtocolOptions& options);
std::string title_of(const Experiment& experiment);

// Runs all experiments. `progress` receives the share done, 0 … 1, and the row's title.
std::vector<Row> run_protocol(const ProtocolOptions& options,
                              const std::function<void(double, const char*)>& progress);

nlohmann::json to_json(const std::vector<Row>& rows);

}  // namespace lab
