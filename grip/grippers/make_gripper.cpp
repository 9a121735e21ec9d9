#include "grip/grippers/gripper.hpp"

namespace slipd::grip {

std::unique_ptr<Gripper> make_gripper(const nlohmann::json& settings, double most_n) {
  const std::string type = settings.at("type");
  if (type == "line") return make_line_gripper(settings);
  if (type == "modbus") return make_modbus_gripper(settings, most_n);
  return make_simulated_gripper(settings);
}

}  // namespace slipd::grip
