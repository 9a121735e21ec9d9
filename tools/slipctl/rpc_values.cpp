#include "tools/slipctl/rpc_values.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "clients/c/json_values.hpp"
#include "tools/slipctl/client.hpp"

namespace slipctl {
namespace {

using json = nlohmann::ordered_json;

using slipd::client::count;
using slipd::client::flag;
using slipd::client::integer;
using slipd::client::member;
using slipd::client::number;
using slipd::client::text;

std::vector<double> numbers(const json& object, const char* key) {
  const json& values = member(object, key);
  std::vector<double> result;
  result.reserve(values.size());
  for (const json& value : values) result.push_back(value.is_number() ? value.get<double>() : 0.0);
  return result;
}

}  // namespace

std::vector<SensorInfo> sensors_from(const json& result) {
  std::vector<SensorInfo> sensors;
  for (const json& each : member(result, "sensors"))
    sensors.push_back({text(each, "name"), text(each, "driver"), text(each, "class"), text(each, "method"),
                       count(each, "taxels"), number(each, "rate_hz").value_or(0), flag(each, "simulated"),
                       flag(each, "connected")});
  return sensors;
}

std::vector<EstimateValues> grasps_from(const json& result) {
  std::vector<EstimateValues> grasps;
  for (const json& each : member(result, "grasps")) grasps.push_back(estimate_from(each));
  return grasps;
}

json part_of_gamma(const json& result, const std::string& name) {
  json sensors = json::array(), grasps = json::array();
  std::string known;
  const auto know = [&](const std::string& each) { known += (known.empty() ? "" : ", ") + each; };
  for (const json& sensor : member(result, "sensors")) {
    know(text(sensor, "sensor"));
    if (text(sensor, "sensor") == name) sensors.push_back(sensor);
  }
  for (const json& grasp : member(result, "grasps")) {
    know(text(grasp, "grasp"));
    const json& fingers = member(grasp, "sensors");
    if (text(grasp, "grasp") == name || std::find(fingers.begin(), fingers.end(), name) != fingers.end())
      grasps.push_back(grasp);
  }
  if (sensors.empty() && grasps.empty())
    throw ClientError("there is no sensor or grasp \"" + name +
                      "\"; there are: " + (known.empty() ? "none" : known));
  return {{"sensors", std::move(sensors)}, {"grasps", std::move(grasps)}};
}

TaxelFrame frame_from(const json& result) {
  TaxelFrame frame{count(result, "seq"),          integer(result, "time_ns"),    numbers(result, "normal_pa"),
                   numbers(result, "shear_x_pa"), numbers(result, "shear_y_pa"), numbers(result, "x_mm"),
                   numbers(result, "y_mm")};
  const std::size_t taxels = frame.normal_pa.size();
  for (const auto* values : {&frame.shear_x_pa, &frame.shear_y_pa, &frame.x_mm, &frame.y_mm})
    if (values->size() != taxels) throw ClientError("the daemon's frame has columns of different lengths");
  return frame;
}

std::vector<SensorCounts> counts_from(const json& result) {
  std::vector<SensorCounts> all;
  for (const json& each : member(result, "sensors")) {
    const json& latency = member(each, "latency_us");
    all.push_back({text(each, "name"), count(each, "received"), count(each, "estimated"),
                   count(each, "skipped"), count(each, "corrupt"), count(each, "gaps"),
                   count(each, "reconnects"), number(each, "rate_hz"), number(latency, "p50"),
                   number(latency, "p99"), number(latency, "p99.9"), number(latency, "max")});
  }
  return all;
}

}  // namespace slipctl
