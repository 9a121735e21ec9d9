#include "daemon/rpc/tradeoff_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace slipd {
namespace {

using json = nlohmann::ordered_json;

json number(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

// A method without such a setting has 0 of it.
json setting(int value) {
  return value > 0 ? json(value) : json(nullptr);
}

}  // namespace

json tradeoff_json(const std::string& sensor, const std::string& chosen, double budget_us,
                   const WorkPrecision& work_precision) {
  json table = json::array();
  for (const auto& row : work_precision.rows) {
    table.push_back({{"method", row.method},
                     {"rank", setting(row.settings.rank)},
                     {"rings", setting(row.settings.rings)},
                     {"neighbours", setting(row.settings.neighbours)},
                     {"precision", to_string(row.settings.precision)},
                     {"memory_bytes", row.settings.memory_bytes},
                     {"mean_error", number(row.mean_error)},
                     {"p95_error", number(row.p95_error)},
                     {"class_right", number(row.right)},
                     {"answered", number(row.answered)},
                     {"within_sigma", number(row.within_sigma)},
                     {"within_two_sigma", number(row.within_two_sigma)},
                     {"p50_us", number(row.p50_us)},
                     {"p99_us", number(row.p99_us)}});
  }
  return {{"sensor", sensor},
          {"chosen", chosen},
          {"budget_us", budget_us},
          {"processor", work_precision.processor},
          {"rows", std::move(table)}};
}

}  // namespace slipd
