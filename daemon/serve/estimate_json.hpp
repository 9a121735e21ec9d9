// How an estimate and a grasp look on the socket: the one place that turns them into JSON. io thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/estimate/estimate.hpp"
#include "daemon/board/clock.hpp"

namespace slipd {

// Members in the order in which a person reads them. An unknown number is null, never NaN. Before the first
// frame there is no sample: times and age are null. `truth` is there only for a simulated sensor.
nlohmann::ordered_json estimate_json(const Estimate& estimate, const std::string& sensor, bool simulated,
                                     const Now& now);

nlohmann::ordered_json grasp_json(const Estimate& together, const std::string& name,
                                  const std::vector<std::string>& sensors);

}  // namespace slipd
