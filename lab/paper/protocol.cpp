#include "lab/paper/protocol.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace lab {
namespace {

using nlohmann::json;
using slipd::Quantity;

constexpr double kOffCentreM = 0.002;
constexpr std::size_t kColumnTests = 500;

const char* symbol_of(Quantity quantity) {
  switch (quantity) {
    case Quantity::pressure:
      return "p";
    case Quantity::shear:
      return "q";
    default:
      return "alpha";
  }
}

std::vector<int> bases_up_to(int most) {
  std::vector<int> bases;
  for (int b = 1; b <= std::min(most, 20); ++b) bases.push_back(b);
  for (const int b : {30, 50, 70, 100}) {
    if (b <= most) bases.push_back(b);
  }
  return bases;
}

json to_json(const Spread& spread) {
  return {{"mean", spread.mean}, {"low", spread.low}, {"high", spread.high}};
}

}  // namespace

double explained(const Outcome& outcome, std::size_t bases) {
  double sum = 0;
  for (std::size_t i = 0; i < std::min(bases, outcome.variance.size()); ++i) sum += outcome.variance[i];
  return sum;
}

Spread spread_of(const Row& row, const std::function<double(const Outcome&)>& figure) {
  Spread spread{0, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const auto& outcome : row.outcomes) {
    const double value = figure(outcome);
    spread.mean += value / static_cast<double>(row.outcomes.size());
    spread.low = std::min(spread.low, value);
    spread.high = std::max(spread.high, value);
  }
  return spread;
}

std::string title_of(const Experiment& experiment) {
  std::string title = std::string("X_") + symbol_of(experiment.quantity) + ", noise " +
                      std::to_string(static_cast<int>(std::lround(100 * experiment.noise))) + " %";
  return title + (experiment.offset_m == 0 ? ", centred" : ", up to 2 mm off");
}

std::vector<Experiment> protocol(const ProtocolOptions& options) {
  std::vector<Experiment> all;
  const auto add = [&](Quantity quantity, double noise, double offset_m, int bases, bool columns) {
    Experiment experiment{.quantity = quantity,
                          .noise = noise,
                          .offset_m = offset_m,
                          .size = {},
                          .side = 100,
                          .bases = bases_up_to(options.fast ? std::min(bases, 20) : bases),
                          .column_tests = columns ? kColumnTests : 0,
                          .seed = options.first_seed,
                          .threads = options.threads};
    if (options.fast) {
      experiment.size = {.contacts = 60, .loads = 20};
      experiment.side = 24;
    }
    all.push_back(std::move(experiment));
  };
  add(Quantity::alpha, 0, 0, 100, true);
  add(Quantity::alpha, 0.04, 0, 100, true);
  add(Quantity::alpha, 0.10, 0, 100, true);
  add(Quantity::alpha, 1, 0, 20, true);
  add(Quantity::alpha, 0.04, kOffCentreM, 20, false);
  add(Quantity::shear, 0.04, 0, 20, false);
  add(Quantity::pressure, 0.04, 0, 20, false);
  return all;
}

std::vector<Row> run_protocol(const ProtocolOptions& options,
                              const std::function<void(double, const char*)>& progress) {
  std::vector<Row> rows;
  const std::vector<Experiment> experiments = protocol(options);
  const double runs = static_cast<double>(experiments.size()) * options.seeds;
  double done = 0;
  for (const auto& experiment : experiments) {
    Row row{title_of(experiment), experiment, {}};
    for (int s = 0; s < options.seeds; ++s, ++done) {
      Experiment seeded = experiment;
      seeded.seed = options.first_seed + static_cast<std::uint64_t>(s);
      row.outcomes.push_back(
          run(seeded, [&](double share) { progress((done + share) / runs, row.title.c_str()); }));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

json to_json(const std::vector<Row>& rows) {
  json result = json::array();
  for (const Row& row : rows) {
    const Experiment& of = row.experiment;
    json knn = json::array();
    for (std::size_t b = 0; b < row.outcomes.front().random.size(); ++b) {
      json entry{{"bases", of.bases[b]},
                 {"random", to_json(spread_of(row, [&](const Outcome& o) { return o.random[b]; }))}};
      if (b < row.outcomes.front().by_contact.size()) {
        entry["by_contact"] = to_json(spread_of(row, [&](const Outcome& o) { return o.by_contact[b]; }));
      }
      knn.push_back(std::move(entry));
    }
    json variance = json::array();
    for (std::size_t i = 0; i < row.outcomes.front().variance.size(); ++i) {
      variance.push_back(to_json(spread_of(row, [&](const Outcome& o) { return o.variance[i]; })));
    }
    json entry{{"title", row.title},
               {"quantity", symbol_of(of.quantity)},
               {"noise", of.noise},
               {"noise_on", "the quantity itself, of each column's maximum"},
               {"offset_mm", 1e3 * of.offset_m},
               {"grid", of.side},
               {"contacts", of.size.contacts},
               {"loads", of.size.loads},
               {"first_seed", of.seed},
               {"seeds", row.outcomes.size()},
               {"variance", std::move(variance)},
               {"knn", std::move(knn)}};
    if (of.column_tests > 0) {
      entry["full_columns"] = {
          {"tests", of.column_tests},
          {"random", to_json(spread_of(row, [](const Outcome& o) { return o.random_columns; }))},
          {"by_contact", to_json(spread_of(row, [](const Outcome& o) { return o.by_contact_columns; }))}};
    }
    result.push_back(std::move(entry));
  }
  return result;
}

}  // namespace lab
