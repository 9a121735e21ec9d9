// What slipd-grip says of itself, asked on its socket for orders (docs/grip.md).
#pragma once

#include <optional>
#include <string>

namespace slipctl {

struct GripWatch {
  std::string state;               // "holding", …; or why it is not known: then without the rest
  std::string why;                 // the event that led there
  std::optional<double> force_n;   // that is ordered of each finger
  std::optional<double> width_mm;  // as the gripper tells it
  std::string trouble;             // it does not answer, or contradicts the sensors; empty: neither
};

// None: nobody takes orders there, so there is nothing to show. Waits for 0.1 s at most.
std::optional<GripWatch> ask_grip(const std::string& path);

}  // namespace slipctl
