#include "tools/slipctl/commands.hpp"

#include <chrono>
#include <iostream>
#include <string_view>
#include <thread>
#include <vector>

#include "tools/slipctl/client.hpp"
#include "tools/slipctl/number_text.hpp"
#include "tools/slipctl/rpc_values.hpp"
#include "tools/slipctl/table.hpp"

namespace slipctl {
namespace {

using json = nlohmann::ordered_json;

json ask(const CommonOptions& common, const char* method, const json& params = json::object()) {
  return RpcClient(common.socket).call(method, params);
}

}  // namespace

void print_status(const CommonOptions& common) {
  const json status = ask(common, "status");
  std::cout << (common.json ? status.dump() + "\n" : tree(status));
}

void print_sensors(const CommonOptions& common) {
  const json result = ask(common, "sensors");
  if (common.json) {
    std::cout << result.dump() << '\n';
    return;
  }
  json sensors = result.value("sensors", json::array());
  for (json& sensor : sensors) {
    if (!sensor.value("connected", false) || sensor.value("receiving", true)) continue;
    const bool estimates = sensor.value("method", json()).is_string();
    sensor["connected"] = estimates ? "open, no frames" : "open, no estimator";
  }
  std::cout << table_of(sensors,
                        {"name", "driver", "class", "taxels", "rate_hz", "method", "simulated", "connected"});
}

void print_gamma(const CommonOptions& common, const std::string& name) {
  const json all = ask(common, "gamma");
  const json result = name.empty() ? all : part_of_gamma(all, name);
  if (common.json) {
    std::cout << result.dump() << '\n';
    return;
  }
  const json sensors = result.value("sensors", json::array()), grasps = result.value("grasps", json::array());
  if (name.empty() || !sensors.empty())
    std::cout << table_of(sensors, {"sensor", "state", "gamma", "sigma", "class", "friction", "normal_n",
                                    "shear_n", "alert", "method", "age_ms", "simulated"});
  if (!sensors.empty() && !grasps.empty()) std::cout << '\n';
  if (!grasps.empty()) std::cout << tree({{"grasps", grasps}});
}

void print_frame(const CommonOptions& common, const std::string& sensor) {
  const json result = ask(common, "frame", {{"sensor", sensor}});
  if (common.json) {
    std::cout << result.dump() << '\n';
    return;
  }
  const TaxelFrame frame = frame_from(result);
  std::cout << "x_mm,y_mm,normal_pa,shear_x_pa,shear_y_pa\n";
  for (std::size_t i = 0; i < frame.x_mm.size(); ++i)
    std::cout << frame.x_mm[i] << ',' << frame.y_mm[i] << ',' << frame.normal_pa[i] << ','
              << frame.shear_x_pa[i] << ',' << frame.shear_y_pa[i] << '\n';
}

void print_metrics(const CommonOptions& common) {
  const json metrics = ask(common, "metrics");
  std::cout << (common.json ? metrics.dump() + "\n" : metrics.get<std::string>());
}

// Waits until all recordings are written, or have failed.
int keep_flight(const CommonOptions& common, const std::string& sensor) {
  constexpr auto kLook = std::chrono::milliseconds(50);
  constexpr std::chrono::seconds kWriting{60};  // the longest that writing all of them may take
  RpcClient client(common.socket);
  const json asked = client.call("flight", sensor.empty() ? json::object() : json{{"sensor", sensor}});
  const json names = asked.value("sensors", json::array()),
             numbers = asked.value("recordings", json::array());
  const auto last_moment = std::chrono::steady_clock::now() + kWriting +
                           std::chrono::ceil<std::chrono::milliseconds>(
                               std::chrono::duration<double>(asked.value("written_in_s", 0.0)));
  json ended = json::array();
  std::vector<bool> done(names.size(), false);
  while (ended.size() < names.size()) {
    if (std::chrono::steady_clock::now() > last_moment)
      throw ClientError("the recording is not written yet; see recorder in slipctl status");
    std::this_thread::sleep_for(kLook);
    const json recorder = client.call("status").value("recorder", json());
    if (!recorder.is_object()) throw ClientError("the flight recorder was switched off meanwhile");
    for (const json& one : recorder.value("last", json::array())) {
      for (std::size_t i = 0; i < names.size(); ++i) {
        if (done[i] || one.value("sensor", "") != names[i].get<std::string>() ||
            one.value("recording", std::uint64_t{0}) < numbers.at(i).get<std::uint64_t>())
          continue;
        done[i] = true;
        ended.push_back(one);
      }
    }
  }
  bool all_well = true;
  for (const json& one : ended) {
    const bool well = one["trouble"].is_null();
    all_well = all_well && well;
    if (!common.json)
      (well ? std::cout : std::cerr) << one.value("sensor", "") << ": "
                                     << (well ? one["file"] : one["trouble"]).get<std::string>() << '\n';
  }
  if (common.json) std::cout << json{{"recordings", ended}}.dump() << '\n';
  return all_well ? 0 : 1;
}

void print_dbc(const CommonOptions& common) {
  const json dbc = ask(common, "dbc");
  std::cout << (common.json ? dbc.dump() + "\n" : dbc.get<std::string>());
}

// The daemon names the parameter of its method; here it is an option.
std::string in_words_of_slipctl(std::string text, const std::string& sensor) {
  constexpr std::string_view kParameter = "ask with \"force\": true";
  if (const auto at = text.find(kParameter); at != std::string::npos)
    text.replace(at, kParameter.size(), "say slipctl rebias --force " + sensor);
  return text;
}

void rebias(const CommonOptions& common, const std::string& sensor, bool force) {
  // Longer than the daemon collects frames for.
  json params{{"sensor", sensor}};
  if (force) params["force"] = true;
  const json result = [&] {
    try {
      return RpcClient(common.socket).call("rebias", params, std::chrono::seconds(35));
    } catch (const RpcError& refused) {
      throw RpcError(refused.code(), in_words_of_slipctl(refused.what(), sensor));
    }
  }();
  if (common.json) {
    std::cout << result.dump() << '\n';
    return;
  }
  std::cout << sensor << ": zeroed";
  if (const json noise = result.value("noise_normal_pa", json()); noise.is_number())
    std::cout << ", noise " << noise.get<double>() << " Pa";
  std::cout << '\n';
  if (const json trouble = result.value("trouble", json()); trouble.is_string())
    std::cerr << "slipctl: the zero is lost with the next start: " << trouble.get<std::string>() << '\n';
}

void releasing(const CommonOptions& common, const std::string& sensor, double seconds) {
  json params{{"seconds", seconds}};
  if (!sensor.empty()) params["sensor"] = sensor;
  const json result = ask(common, "releasing", params);
  if (common.json) {
    std::cout << result.dump() << '\n';
    return;
  }
  const std::string what =
      seconds > 0 ? "no alert of slip for " + json(seconds).dump() + " s" : "alerts again";
  for (const json& name : result["sensors"]) std::cout << name.get<std::string>() << ": " << what << '\n';
}

}  // namespace slipctl
