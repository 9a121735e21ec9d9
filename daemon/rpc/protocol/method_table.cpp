#include "daemon/rpc/protocol/method_table.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "daemon/rpc/protocol/rpc.hpp"

namespace slipd::rpc {
namespace {

using Ordered = nlohmann::ordered_json;

constexpr std::string_view kObject = R"({"type":"object"})";
constexpr std::string_view kText = R"({"type":"string"})";
constexpr Parameter kSensor{"sensor", true, kText, "name of a sensor"};
constexpr Parameter kAnySensor{"sensor", false, kText, "name of a sensor; absent: all"};

std::vector<MethodFacts> make_methods() {
  constexpr std::string_view kNames = R"({"type":"array","items":{"type":"string"}})";
  return {
      {"version", {}, kObject, "Name, version and number of the protocol"},
      {"sensors", {}, kObject, "The sensors that are configured, and how they are"},
      {"gamma", {kAnySensor}, kObject, "The latest estimate of each sensor and of each grasp"},
      {"status", {}, kObject, "Counts, rates, latencies, zeros, outputs, clients"},
      {"frame",
       {kSensor,
        {"encoding", false, R"({"enum":["base64","bytes"]})",
         "values in base64, without places: base64 as float32, bytes as shares of their peaks, a byte each; "
         "absent: as numbers"}},
       kObject,
       "The newest frame, its age and the sensor's state: pressure and shear of each taxel, and where it is"},
      {"tradeoff", {kSensor}, kObject, "Error against time of the estimators measured for a sensor"},
      {"subscribe",
       {{"sensors", false, kNames, "names of sensors; absent: all"},
        {"max_rate_hz", false, R"({"type":"number","minimum":0.001,"maximum":1000000})",
         "estimates a second of each sensor, Hz; absent: all"},
        {"events", false, R"({"type":"array","items":{"enum":["estimate","alert","state"]}})",
         "what to be notified of; absent: estimate"}},
       kObject,
       "Notifications from now on"},
      {"unsubscribe",
       {{"subscription", true, R"({"type":"integer","minimum":1})", "the number that subscribe gave"}},
       R"({"const":true})",
       "Ends a subscription"},
      {"attach",
       {{"wait", false, kNames, "names of sensors and grasps to be woken for; absent: all"}},
       kObject,
       "The board in shared memory, as a descriptor (SCM_RIGHTS)",
       true},
      {"rebias",
       {kSensor, {"force", false, R"({"type":"boolean"})", "also if the sensor seems to be touched"}},
       kObject,
       "Measures the sensor's zero; root and slipd's own user only"},
      {"releasing",
       {kAnySensor,
        {"seconds", true, R"({"type":"number","minimum":0,"maximum":60})",
         "how long from now, s; 0: no longer"}},
       kObject,
       "The robot lets go of the object: sensors that see displacements raise no alert of slip meanwhile"},
      {"record",
       {kSensor,
        {"seconds", true, R"({"type":"number","exclusiveMinimum":0,"maximum":86400})", "how long, s"}},
       kObject,
       "Records frames, and passes a descriptor to read the recording from (SCM_RIGHTS)",
       true},
      {"flight", {kAnySensor}, kObject, "Writes the flight recorder's last seconds to files"},
      {"metrics", {}, kText, "OpenMetrics text"},
      {"dbc", {}, kText, "The definition of slipd's CAN messages"},
      {"rpc.discover", {}, kObject, "This OpenRPC document"},
  };
}

Ordered parameter_json(const Parameter& parameter) {
  return {{"name", parameter.name},
          {"description", parameter.description},
          {"required", parameter.required},
          {"schema", Ordered::parse(parameter.schema)}};
}

Ordered error_json(int code, const char* message) {
  return {{"code", code}, {"message", message}};
}

}  // namespace

std::span<const MethodFacts> methods() {
  static const std::vector<MethodFacts> kMethods = make_methods();
  return kMethods;
}

const MethodFacts& facts_of(std::string_view method) {
  const auto found = std::find_if(methods().begin(), methods().end(),
                                  [&](const MethodFacts& each) { return each.name == method; });
  if (found == methods().end()) throw std::logic_error("no method " + std::string(method) + " in the table");
  return *found;
}

Ordered open_rpc_document() {
  const Ordered errors = Ordered::array(
      {error_json(kInvalidParams, "Invalid params"), error_json(kUnknownSensor, "Unknown sensor"),
       error_json(kNotPermitted, "Not permitted"),
       error_json(kNotPossible, "Not possible for this sensor or at this time"),
       error_json(kTooMuch, "More than slipd keeps for clients that do not read")});
  Ordered list = Ordered::array();
  for (const MethodFacts& method : methods()) {
    Ordered parameters = Ordered::array();
    for (const Parameter& parameter : method.parameters) parameters.push_back(parameter_json(parameter));
    list.push_back({{"name", method.name},
                    {"summary", method.summary},
                    {"paramStructure", "by-name"},
                    {"params", std::move(parameters)},
                    {"result", {{"name", "result"}, {"schema", Ordered::parse(method.result)}}},
                    {"errors", errors}});
  }
  return {{"openrpc", "1.2.6"},
          {"info", {{"title", "slipd"}, {"version", SLIPD_VERSION}}},
          {"methods", std::move(list)}};
}

}  // namespace slipd::rpc
