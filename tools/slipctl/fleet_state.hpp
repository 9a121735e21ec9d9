// What `slipctl fleet` shows: the lines of slipd-fleet (bridges/mqtt/fleet.hpp), and their views. Pure.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tools/slipctl/canvas.hpp"

namespace slipctl {

// One gripper. Texts have no control characters; empty or absent: unknown, or there is none.
struct FleetLine {
  std::string gripper;
  std::string status;                            // online, offline or unknown
  std::string state;                             // the worst state of its sensors and grasps
  std::string state_of;                          // the sensor or grasp that has it
  std::optional<double> gamma;                   // least margin of the last summary's period
  std::string gamma_of;                          // the sensor or grasp that had it
  std::string alert;                             // the worst alert: none, unknown, warn, slip
  std::optional<std::int64_t> alerts_last_hour;  // that began
  std::optional<std::int64_t> alerts_dropped;    // by a full or failing disk
  std::string version;                           // of slipd
  bool simulated = false;                        // one of its sensors is
  std::optional<std::int64_t> offline_since_ns;  // CLOCK_REALTIME of its last sign of life
};

struct FleetState {
  std::string broker;                      // HOST:PORT; empty: not heard of yet
  bool connected = false;                  // false: nothing is known, and there are no lines
  std::string trouble;                     // why not
  std::map<std::string, FleetLine> lines;  // by gripper
};

// Takes one line of slipd-fleet. Returns the gripper that it is of; empty: of the broker, or no such line.
std::string take_fleet_line(FleetState& state, const std::string& json);

// Grippers that need a person first: slipping, offline, warned, without a margin, then by margin.
std::vector<const FleetLine*> by_urgency(const FleetState& state);

// The whole screen.
Canvas draw_fleet(const FleetState& state, int columns, int rows);

// All grippers in the order of their names, as a table.
std::string fleet_table(const FleetState& state);

// One gripper as a line of text.
std::string fleet_text(const FleetLine& line);

}  // namespace slipctl
