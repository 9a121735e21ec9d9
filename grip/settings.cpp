#include "grip/settings.hpp"

#include <algorithm>
#include <optional>

#include "grip/grippers/gripper_profile.hpp"
#include "schema/schema.hpp"

namespace slipd::grip {
namespace {

constexpr double kMsPerSecond = 1000;

// A gripper of a profile holds with no less than it can.
double least_n_of(const nlohmann::json& gripper) {
  return gripper.at("type") == "modbus" ? load_profile(gripper.at("profile")).least_n() : 0;
}

LawSettings law_of(const nlohmann::json& checked, int fingers) {
  const nlohmann::json& force = checked.at("force");
  const double least_n = least_n_of(checked.at("gripper"));
  return {.target_margin = checked.at("target_margin"),
          .firm_by_low = checked.at("firm_by") == "gamma_low",
          .least_n = std::max(least_n, force.at("least_n").get<double>()),
          .firm_n = force.at("firm_n"),
          .most_n = force.at("most_n"),
          .close_n = std::max(least_n, force.at("close_n").get<double>()),
          .resolution_n = force.at("resolution_n"),
          .delay_s = checked.at("gripper").at("delay_ms").get<double>() / kMsPerSecond,
          .raise_n_per_s = force.at("raise_n_per_s"),
          .lower_per_s = force.at("lower_per_s"),
          .settle_s = checked.at("settle_ms").get<double>() / kMsPerSecond,
          .max_age_s = checked.at("max_age_ms").get<double>() / kMsPerSecond,
          .ahead_s = checked.at("ahead_ms").get<double>() / kMsPerSecond,
          .close_timeout_s = checked.at("close_timeout_s"),
          .fingers = fingers};
}

std::string in_newtons(double value) {
  return nlohmann::json(value).dump() + " N";
}

// What the gripper of a profile cannot do would be ordered, and the law would reckon with it.
void check_limits(const nlohmann::json& checked, std::vector<Problem>& problems) {
  const auto add = [&](const std::string& where, const std::string& what) {
    problems.push_back(problem_at(where, checked, what));
  };
  try {
    const GripperProfile profile = load_profile(checked.at("gripper").at("profile"));
    const nlohmann::json& force = checked.at("force");
    for (const char* const key : {"firm_n", "most_n"})
      if (force.at(key) > profile.most_n())
        add(std::string("/force/") + key,
            "is more than the gripper can do: " + in_newtons(profile.most_n()) + " at most");
    if (force.at("most_n") < profile.least_n())
      add("/force/most_n", "is below the gripper's least force, " + in_newtons(profile.least_n()) +
                               "; it cannot hold an object that bears no more");
    if (const auto least = profile.least_speed_mm_s(); least && checked.at("speed_mm_s") < *least)
      add("/speed_mm_s",
          "is less than the gripper can do: " + nlohmann::json(*least).dump() + " mm/s at least");
  } catch (const GripperError& error) {
    add("/gripper/profile", error.what());
  }
}

}  // namespace

Settings settings_of(const nlohmann::json& checked) {
  const auto fingers = checked.at("fingers").get<std::vector<std::string>>();
  const bool alone = !checked.contains("grasp");
  return {.socket = checked.at("socket"),
          .name = alone ? fingers.front() : checked.at("grasp").get<std::string>(),
          .fingers = fingers,
          .speed_mm_s = checked.at("speed_mm_s"),
          .law = law_of(checked, static_cast<int>(fingers.size())),
          .dry_run = checked.at("dry_run"),
          .orders = checked.at("orders"),
          .gripper = checked.at("gripper")};
}

std::vector<Problem> problems_of(const nlohmann::json& checked) {
  std::vector<Problem> problems;
  const auto add = [&](const std::string& where, const std::string& what) {
    problems.push_back(problem_at(where, checked, what));
  };
  const nlohmann::json& force = checked.at("force");
  for (const char* const key : {"least_n", "firm_n", "close_n"})
    if (force.at(key) > force.at("most_n"))
      add(std::string("/force/") + key, "is above most_n; no order may be");
  if (force.at("least_n") > force.at("firm_n")) add("/force/least_n", "is above firm_n");
  if (!checked.contains("grasp") && checked.at("fingers").size() > 1)
    add("/fingers",
        "several fingers hold by one margin, which only a grasp of slipd has: name it in \"grasp\"");
  const nlohmann::json& gripper = checked.at("gripper");
  const std::string type = gripper.at("type");
  const auto needs = [&](const char* key) {
    if (!gripper.contains(key)) add("/gripper", "type \"" + type + "\" needs \"" + key + "\"");
  };
  if (type == "line" && gripper.contains("socket") == gripper.contains("command"))
    add("/gripper", "type \"line\" needs either \"socket\" or \"command\"");
  if (type == "simulated") needs("grip_inputs");
  if (type == "modbus") {
    needs("profile");
    needs("at");
    if (gripper.contains("profile")) check_limits(checked, problems);
  }
  return problems;
}

}  // namespace slipd::grip
