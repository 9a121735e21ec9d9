// slipd-grip's settings in SI units. The schema is grip.schema.json.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grip/law.hpp"
#include "schema/schema.hpp"

namespace slipd::grip {

struct Settings {
  std::string socket;  // slipd's
  std::string name;    // of the grasp or sensor whose margin counts
  std::vector<std::string> fingers;
  double speed_mm_s = 0;
  LawSettings law;
  bool dry_run = false;
  std::string orders;  // path of the socket for orders
  nlohmann::json gripper;
};

// Of JSON that fits the schema and `problems_of`.
Settings settings_of(const nlohmann::json& checked);

// What the schema cannot state.
std::vector<Problem> problems_of(const nlohmann::json& checked);

}  // namespace slipd::grip
