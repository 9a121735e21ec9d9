// What the topic /diagnostics says of a sensor or grasp. Any thread that may allocate.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "bridges/ros2/messages/messages.hpp"

namespace slipd::ros2 {

// `hardware`: the driver. `rate_hz`: frames a second. `dropped`: estimates that slipd dropped since the
// start.
DiagnosticStatus status_of(const SlipEstimate& last, const std::string& hardware,
                           std::optional<double> rate_hz, std::uint64_t dropped);

}  // namespace slipd::ros2
