#include "bridges/grip_ros2/order_lines.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace slipd::grip_ros2 {

std::optional<Order> order_of(const std::string& line) {
  const nlohmann::json said = nlohmann::json::parse(line, nullptr, false);
  if (!said.is_object() || !said.contains("order")) return std::nullopt;
  const nlohmann::json& move = said["order"];
  if (move == "stay") return Order{Move::stay};
  if (move == "open") return Order{Move::open};
  const auto force = said.find("force_n");
  if (move != "grip" || force == said.end() || !force->is_number()) return std::nullopt;
  const double force_n = force->get<double>();
  if (!(force_n >= 0) || !std::isfinite(force_n)) return std::nullopt;
  return Order{Move::grip, force_n};
}

std::string answer_of(std::optional<double> width_mm, std::optional<double> force_n) {
  nlohmann::json answer = nlohmann::json::object();
  if (width_mm && std::isfinite(*width_mm)) answer["width_mm"] = *width_mm;
  if (force_n && std::isfinite(*force_n)) answer["force_n"] = *force_n;
  return answer.dump();
}

std::string fault(const std::string& what) {
  return nlohmann::json{{"fault", what}}.dump();
}

}  // namespace slipd::grip_ros2
