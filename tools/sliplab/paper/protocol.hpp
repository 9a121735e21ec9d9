// The rows of the paper's table: which experiments, how often, and their results over the seeds.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/sliplab/paper/experiment.hpp"

namespace sliplab {

struct ProtocolOptions {
  bool fast = false;  // a small grid and few contacts: shows that it works, says nothing about the paper
  int seeds = 5;
  std::uint64_t first_seed = 1;
  unsigned threads = 2;
};

// One experiment, repeated with the contacts, the noise and the split of each seed.
struct Row {
  std::string title;
  Experiment experiment;          // of the first seed
  std::vector<Outcome> outcomes;  // one a seed
};

// Mean, least and greatest of one figure over the seeds. Shares, 0 … 1.
struct Spread {
  double mean = 0, low = 0, high = 0;
};
Spread spread_of(const Row& row, const std::function<double(const Outcome&)>& figure);

// The share that the first `bases` explain together.
double explained(const Outcome& outcome, std::size_t bases);

std::vector<Experiment> protocol(const ProtocolOptions& options);
std::string title_of(const Experiment& experiment);

// Runs all of it. `progress`: 0 … 1 of the whole, and the row's title.
std::vector<Row> run_protocol(const ProtocolOptions& options,
                              const std::function<void(double, const char*)>& progress);

nlohmann::json to_json(const std::vector<Row>& rows);

}  // namespace sliplab
