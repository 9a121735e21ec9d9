// What slipd-grip needs of a gripper, and what a gripper may tell. Each kind has its file. The functions of
// one gripper are called from one thread, GripperThread's, and may wait.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "grip/grippers/order.hpp"

namespace slipd::grip {

// The gripper cannot be reached or does not answer; what() says where, what, and what to do.
class GripperError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// It answers that it cannot do what it was told: the connection stands.
class GripperFault : public GripperError {
  using GripperError::GripperError;
};

// What is sent: an order, and the estimate that it answers.
struct Command {
  Order order;
  double speed_mm_s = 0;
  std::uint64_t sequence = 0;  // of the estimate
  bool operator==(const Command&) const = default;
};

// What a gripper tells of itself, as far as it does.
struct GripperFacts {
  std::optional<double> width_mm;
  std::optional<double> force_n;
};

class Gripper {
 public:
  virtual ~Gripper() = default;
  // Makes the connection, and again after a GripperError. Must not move the gripper. Throws GripperError.
  virtual void connect() = 0;
  // None: the gripper is busy, and the command has to be repeated. Throws GripperError.
  virtual std::optional<GripperFacts> obey(const Command& command) = 0;
  // Whether each command is sent, also one that is the last one again.
  virtual bool wants_each() const { return false; }
  // Between commands, of a gripper that does not want each: what it tells now. Throws GripperError where it
  // does not obey the last command any more.
  virtual GripperFacts look(const Command& /*last*/) { return {}; }
};

// From the settings' object "gripper", which fits the schema, and the most force of a finger. Throws
// GripperError for what cannot work.
std::unique_ptr<Gripper> make_gripper(const nlohmann::json& settings, double most_n);

std::unique_ptr<Gripper> make_line_gripper(const nlohmann::json& settings);
std::unique_ptr<Gripper> make_simulated_gripper(const nlohmann::json& settings);
std::unique_ptr<Gripper> make_modbus_gripper(const nlohmann::json& settings, double most_n);
std::unique_ptr<Gripper> make_dry_gripper();

}  // namespace slipd::grip
