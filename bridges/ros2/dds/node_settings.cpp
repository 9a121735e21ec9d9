#include "bridges/ros2/dds/node_settings.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "bridges/ros2/dds/host_network.hpp"

namespace slipd::ros2 {

std::vector<Problem> network_problems(const nlohmann::json& settings) {
  std::vector<Problem> problems;
  const nlohmann::json& network = settings.at("network");
  const nlohmann::json& interfaces = network.at("interfaces");
  for (const char* const name : {"lo", kHost}) {
    if (interfaces.size() > 1 && std::find(interfaces.begin(), interfaces.end(), name) != interfaces.end())
      problems.push_back(problem_of("/network/interfaces", interfaces,
                                    std::string(name) +
                                        " beside others: name the others only, as nodes of this computer use "
                                        "them, too"));
  }
  if (!network.at("multicast").get<bool>() && network.at("peers").empty())
    problems.push_back(problem_of("/network/peers", network.at("peers"),
                                  "no peers and no multicast: no node could be found; give one of them"));
  return problems;
}

NodeOptions node_options(const nlohmann::json& settings) {
  const nlohmann::json& network = settings.at("network");
  return {.domain = settings.at("domain"),
          .interfaces = network.at("interfaces"),
          .multicast = network.at("multicast"),
          .peers = network.at("peers"),
          .name = settings.at("node"),
          .name_space = "/",
          .humble = settings.at("distribution") == "humble"};
}

}  // namespace slipd::ros2
