#include "tools/slipctl/commands.hpp"

#include <iostream>

#include "tools/slipctl/client.hpp"
#include "tools/slipctl/number_text.hpp"
#include "tools/slipctl/rpc_values.hpp"
#include "tools/slipctl/table.hpp"

namespace slipctl {
namespace {

using json = nlohmann::ordered_json;

json ask(const CommonOptions& common, const char* method, json params = json::object()) {
  return RpcClient(common.socket).call(method, std::move(params));
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
    if (sensor.value("connected", false) && !sensor.value("receiving", true))
      sensor["connected"] = "open, no frames";
  }
  std::cout << table_of(sensors,
                        {"name", "driver", "class", "taxels", "rate_hz", "method", "simulated", "connected"});
}

void print_gamma(const CommonOptions& common, const std::string& sensor) {
  const json result = ask(common, "gamma", sensor.empty() ? json::object() : json{{"sensor", sensor}});
  if (common.json) {
    std::cout << result.dump() << '\n';
    return;
  }
  std::cout << table_of(result.value("sensors", json::array()),
                        {"sensor", "state", "gamma", "sigma", "class", "friction", "normal_n", "shear_n",
                         "alert", "method", "age_ms", "simulated"});
  if (const json grasps = result.value("grasps", json::array()); !grasps.empty())
    std::cout << '\n' << tree({{"grasps", grasps}});
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

void keep_flight(const CommonOptions& common, const std::string& sensor) {
  const json result = ask(common, "flight", sensor.empty() ? json::object() : json{{"sensor", sensor}});
  if (common.json)
    std::cout << result.dump() << '\n';
  else
    std::cout << "in " << result.value("written_in_s", 0.0) << " s in " << result.value("folder", "") << '\n';
}

void print_dbc(const CommonOptions& common) {
  const json dbc = ask(common, "dbc");
  std::cout << (common.json ? dbc.dump() + "\n" : dbc.get<std::string>());
}

void rebias(const CommonOptions& common, const std::string& sensor, bool force) {
  // Longer than the daemon collects frames for.
  json params{{"sensor", sensor}};
  if (force) params["force"] = true;
  const json result = RpcClient(common.socket).call("rebias", params, std::chrono::seconds(35));
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

}  // namespace slipctl
