#include "grip/gripper.hpp"

namespace slipd::grip {

std::unique_ptr<Gripper> make_gripper(const nlohmann::json& settings) {
  const std::string type = settings.at("type");
  if (type == "line") return make_line_gripper(settings);
  return make_simulated_gripper(settings);
}

}  // namespace slipd::grip
