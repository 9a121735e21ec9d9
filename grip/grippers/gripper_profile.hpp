// A gripper's registers, from a JSON file (gripper_profile.schema.json): what is written for an order, and
// what is read. Plain values.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "grip/grippers/gripper.hpp"
#include "schema/schema.hpp"

namespace slipd::grip {

// Registers in order, from `first` on.
struct RegisterWrite {
  int first = 0;
  std::vector<std::uint16_t> values;
};

class GripperProfile {
 public:
  // From JSON that fits the schema.
  explicit GripperProfile(const nlohmann::json& json);

  bool is_rtu() const { return json_.at("modbus").at("transport") == "rtu"; }
  int unit() const { return json_.at("modbus").at("unit"); }
  int baud() const { return json_.at("modbus").at("baud"); }
  double least_n() const { return json_.at("force").at("range_n").at(0); }
  double most_n() const { return json_.at("force").at("range_n").at(1); }
  // The slowest that it moves, mm/s; nothing where no speed can be chosen.
  std::optional<double> least_speed_mm_s() const;

  // For Move::open and Move::grip. The force is rounded up to the gripper's step, unless that exceeds
  // `most_n`.
  RegisterWrite write(const Command& command, double most_n) const;
  // What makes a gripper ready that is not: may move it. Empty: nothing does.
  std::vector<RegisterWrite> activation() const;

  // What is read: holding or input registers.
  bool reads_input() const { return json_.at("read").at("function") == "input"; }
  int read_first() const { return json_.at("read").at("first"); }
  int read_count() const { return json_.at("read").at("count"); }

  struct Status {
    bool ready = true;
    bool busy = false;
    bool fault = false;
    GripperFacts facts;
  };
  Status status(std::span<const std::uint16_t> registers) const;

 private:
  std::uint16_t force_count(double force_n, double most_n) const;

  nlohmann::json json_;
};

// What the schema of a profile cannot state.
std::vector<Problem> problems_of_profile(const nlohmann::json& checked);

// A shipped profile by its name, or one in a file by its path. Throws GripperError.
GripperProfile load_profile(const std::string& name_or_path);

}  // namespace slipd::grip
