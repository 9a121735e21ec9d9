// Which sensors and grasps a slipd has, from its answers on the socket. Any one thread.
#pragma once

#include <slipd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace slipd::bridges {

struct SensorFacts {
  // Name in slipd's configuration.
  std::string name;
  // Name of the driver.
  std::string driver;
  // array3, wrench, normal or displacement.
  std::string kind;
  // Number of taxels; 0: unknown.
  int taxels = 0;
  // Configured rate, Hz; 0: unknown.
  double rate_hz = 0;
  // Whether it is a simulated sensor.
  bool simulated = false;
  bool operator==(const SensorFacts&) const = default;
};

struct GraspFacts {
  // Name in slipd's configuration.
  std::string name;
  // Names of its sensors.
  std::vector<std::string> sensors;
  bool operator==(const GraspFacts&) const = default;
};

struct Inventory {
  // Version of slipd.
  std::string version;
  // In the configuration's order.
  std::vector<SensorFacts> sensors;
  // In the configuration's order.
  std::vector<GraspFacts> grasps;

  bool has_sensor(std::string_view name) const;
  // A sensor or a grasp.
  bool has(std::string_view name) const;
  bool operator==(const Inventory&) const = default;
};

// From the answers to `version`, `sensors` and `gamma`, as JSON text (docs/socket.md). A key that is missing,
// or of another type, gives the field's default. Throws std::runtime_error for a text that is no JSON object.
Inventory inventory_of(std::string_view version, std::string_view sensors, std::string_view gamma);

// Asks slipd; each of three requests waits at most timeout_s. Throws std::runtime_error with libslipd's text.
Inventory ask_inventory(client::Connection& slipd, double timeout_s);

}  // namespace slipd::bridges
