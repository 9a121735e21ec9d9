#include "daemon/serve/tradeoff_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace slipd {
namespace {

using json = nlohmann::ordered_json;

json number(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

}  // namespace

json tradeoff_json(const std::string& sensor, const std::string& chosen, double budget_us,
                   std::span<const TradeoffRow> rows) {
  json table = json::array();
  for (const auto& row : rows) {
    table.push_back({{"method", to_string(row.method)},
                     {"mean_error", number(row.mean_error)},
                     {"p95_error", number(row.p95_error)},
                     {"class_right", number(row.right)},
                     {"answered", number(row.answered)},
                     {"within_sigma", number(row.within_sigma)},
                     {"within_two_sigma", number(row.within_two_sigma)},
                     {"p50_us", number(row.p50_us)},
                     {"p99_us", number(row.p99_us)}});
  }
  return {{"sensor", sensor}, {"chosen", chosen}, {"budget_us", budget_us}, {"rows", std::move(table)}};
}

}  // namespace slipd
