#include "daemon/rpc/protocol/request_params.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "daemon/rpc/protocol/rpc.hpp"

namespace slipd {

std::size_t sensor_index(const nlohmann::json& name, const Board& board) {
  if (!name.is_string()) throw rpc::Error(rpc::kInvalidParams, "a sensor is named by a string");
  const auto& wanted = name.get_ref<const std::string&>();
  std::string known;
  for (std::size_t i = 0; i < board.sensors.size(); ++i) {
    if (board.sensors[i]->name == wanted) return i;
    known += (i == 0 ? "" : ", ") + board.sensors[i]->name;
  }
  throw rpc::Error(rpc::kUnknownSensor, "there is no sensor \"" + wanted + "\"; there are: " + known);
}

std::size_t required_sensor(const nlohmann::json& params, const Board& board) {
  const auto name = params.find("sensor");
  if (name == params.end()) throw rpc::Error(rpc::kInvalidParams, "\"sensor\" is missing");
  return sensor_index(*name, board);
}

void refuse_unknown(const nlohmann::json& params, const rpc::MethodFacts& method) {
  if (params.empty()) return;
  for (const auto& [key, value] : params.items()) {
    const auto is_it = [&key = key](const rpc::Parameter& known) { return known.name == key; };
    if (std::any_of(method.parameters.begin(), method.parameters.end(), is_it)) continue;
    std::string list;
    for (const rpc::Parameter& known : method.parameters)
      list += (list.empty() ? "" : ", ") + std::string(known.name);
    throw rpc::Error(rpc::kInvalidParams,
                     "there is no parameter \"" + key + "\"" + (list.empty() ? "" : "; there are: " + list));
  }
}

}  // namespace slipd
