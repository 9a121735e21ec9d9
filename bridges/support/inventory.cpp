#include "bridges/support/inventory.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace slipd::bridges {
namespace {

using nlohmann::json;

json object_of(std::string_view text, const char* what) {
  json value = json::parse(text, nullptr, false);
  if (!value.is_object())
    throw std::runtime_error(std::string("slipd's answer to ") + what + " is no JSON object");
  return value;
}

std::string text_at(const json& object, const char* key) {
  const auto at = object.find(key);
  return at != object.end() && at->is_string() ? at->get<std::string>() : std::string();
}

double number_at(const json& object, const char* key) {
  const auto at = object.find(key);
  return at != object.end() && at->is_number() ? at->get<double>() : 0;
}

// The objects of the list `key`; whatever else is there is left out.
std::vector<json> objects_at(const json& object, const char* key) {
  std::vector<json> found;
  const auto at = object.find(key);
  if (at == object.end() || !at->is_array()) return found;
  std::copy_if(at->begin(), at->end(), std::back_inserter(found),
               [](const json& each) { return each.is_object(); });
  return found;
}

SensorFacts sensor_of(const json& object) {
  constexpr double kMostTaxels = 1e6;
  SensorFacts facts;
  facts.name = text_at(object, "name");
  facts.driver = text_at(object, "driver");
  facts.kind = text_at(object, "class");
  facts.taxels = static_cast<int>(std::clamp(number_at(object, "taxels"), 0.0, kMostTaxels));
  facts.rate_hz = number_at(object, "rate_hz");
  facts.simulated = object.contains("simulated") && object["simulated"] == true;
  return facts;
}

GraspFacts grasp_of(const json& object) {
  GraspFacts facts{text_at(object, "grasp"), {}};
  const auto sensors = object.find("sensors");
  if (sensors == object.end() || !sensors->is_array()) return facts;
  for (const json& name : *sensors) {
    if (name.is_string()) facts.sensors.push_back(name.get<std::string>());
  }
  return facts;
}

}  // namespace

bool Inventory::has_sensor(std::string_view name) const {
  return std::any_of(sensors.begin(), sensors.end(),
                     [&](const SensorFacts& each) { return each.name == name; });
}

bool Inventory::has(std::string_view name) const {
  return has_sensor(name) ||
         std::any_of(grasps.begin(), grasps.end(), [&](const GraspFacts& each) { return each.name == name; });
}

Inventory inventory_of(std::string_view version, std::string_view sensors, std::string_view gamma) {
  Inventory inventory;
  inventory.version = text_at(object_of(version, "version"), "version");
  for (const json& each : objects_at(object_of(sensors, "sensors"), "sensors"))
    inventory.sensors.push_back(sensor_of(each));
  for (const json& each : objects_at(object_of(gamma, "gamma"), "grasps"))
    inventory.grasps.push_back(grasp_of(each));
  return inventory;
}

Inventory ask_inventory(client::Connection& slipd, double timeout_s) {
  const auto answer_to = [&](const char* method) { return slipd.call(method, "{}", -1, timeout_s); };
  const std::string version = answer_to("version");
  const std::string sensors = answer_to("sensors");
  return inventory_of(version, sensors, answer_to("gamma"));
}

}  // namespace slipd::bridges
