// `slipctl fleet`: the grippers of an MQTT broker, a line each. slipd-fleet of the package slipd-mqtt talks
// to the broker; this shows what it prints.
#pragma once

#include <string>
#include <vector>

namespace slipctl {

struct FleetOptions {
  // Of slipd-fleet, as on its command line.
  std::vector<std::string> arguments;
  // Print slipd-fleet's own lines.
  bool json = false;
  // Print the present lines and end.
  bool once = false;
};

// The exit code. Throws ClientError if slipd-fleet is not installed.
int fleet(const FleetOptions& options);

}  // namespace slipctl
