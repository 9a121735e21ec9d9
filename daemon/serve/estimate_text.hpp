// How an estimate and a grasp look on the socket: the one place that turns them into JSON. io thread.
#pragma once

#include <string>
#include <vector>

#include "core/estimate/estimate.hpp"
#include "daemon/board/clock.hpp"

namespace slipd {

// Appends an object, its members in the order in which a person reads them. An unknown number is null, never
// NaN. Before the first frame there is no sample: times and age are null. `truth` is there only for a
// simulated sensor.
void append_estimate(std::string& out, const Estimate& estimate, const std::string& sensor, bool simulated,
                     const Now& now);

void append_grasp(std::string& out, const Estimate& together, const std::string& name,
                  const std::vector<std::string>& sensors);

}  // namespace slipd
