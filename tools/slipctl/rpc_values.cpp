#include "tools/slipctl/rpc_values.hpp"

#include <nlohmann/json.hpp>

#include "tools/slipctl/client.hpp"

namespace slipctl {
namespace {

using json = nlohmann::ordered_json;

const json& member(const json& object, const char* key) {
  static const json nothing;
  if (!object.is_object()) return nothing;
  const auto found = object.find(key);
  return found == object.end() ? nothing : *found;
}

std::string text(const json& object, const char* key, const char* otherwise = "") {
  const json& value = member(object, key);
  return value.is_string() ? value.get<std::string>() : otherwise;
}

std::optional<double> number(const json& object, const char* key) {
  const json& value = member(object, key);
  return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

std::uint64_t count(const json& object, const char* key) {
  const json& value = member(object, key);
  return value.is_number_integer() && value >= 0 ? value.get<std::uint64_t>() : 0;
}

std::int64_t integer(const json& object, const char* key) {
  const json& value = member(object, key);
  return value.is_number_integer() ? value.get<std::int64_t>() : 0;
}

bool flag(const json& object, const char* key) {
  return member(object, key) == true;
}

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

EstimateView estimate_from(const json& in) {
  EstimateView out;
  out.sensor = text(in, "sensor");
  out.state = text(in, "state", "stale");
  out.alert = text(in, "alert", "none");
  out.alert_cause = text(in, "alert_cause");
  out.sliding = text(in, "sliding");
  out.sliding_for_ms = number(in, "sliding_for_ms");
  out.method = text(in, "method");
  out.sequence = count(in, "seq");
  out.time_ns = integer(in, "time_ns");
  out.gamma = number(in, "gamma");
  out.sigma = number(in, "sigma");
  out.friction = number(in, "friction");
  out.friction_sigma = number(in, "friction_sigma");
  if (const auto value = number(in, "class")) out.slip_class = static_cast<int>(*value);
  out.normal_n = number(in, "normal_n");
  out.shear_n = number(in, "shear_n");
  out.torque_nmm = number(in, "torque_nmm");
  out.torque_sigma_nmm = number(in, "torque_sigma_nmm");
  if (const json& center = member(in, "center_mm");
      center.is_array() && center.size() == 2 && center[0].is_number() && center[1].is_number()) {
    out.center_x_mm = center[0].get<double>();
    out.center_y_mm = center[1].get<double>();
  }
  out.radius_mm = number(in, "radius_mm");
  out.a_over_r = number(in, "a_over_r");
  out.time_to_slip_ms = number(in, "time_to_slip_ms");
  out.grip_increase_n = number(in, "grip_increase_n");
  out.latency_us = number(in, "latency_us");
  out.age_ms = number(in, "age_ms");
  out.true_gamma = number(member(in, "truth"), "gamma");
  out.true_friction = number(member(in, "truth"), "friction");
  out.dropped = count(in, "dropped");
  out.simulated = flag(in, "simulated");
  return out;
}

std::vector<EstimateView> grasps_from(const json& result) {
  std::vector<EstimateView> grasps;
  for (const json& each : member(result, "grasps")) {
    grasps.push_back(estimate_from(each));
    grasps.back().sensor = text(each, "grasp");
  }
  return grasps;
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
