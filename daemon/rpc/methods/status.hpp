// Results of the methods status, sensors, tradeoff and rebias. Called from one thread: io.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/reading/method/work_precision.hpp"
#include "daemon/telemetry/service_context.hpp"

namespace slipd {

// Counters, rates, latencies, and what the system granted.
nlohmann::ordered_json status_json(const ServiceContext& context);

// A sensor's bias; null if its device subtracts it.
nlohmann::ordered_json zero_json(const SensorStatus& status);

// The list of sensors.
nlohmann::ordered_json sensors_json(const ServiceContext& context);

// {"sensor", "chosen", "budget_us", "processor", "rows": [{"method", "mean_error", …}]}; unknown numbers are
// null.
nlohmann::ordered_json tradeoff_json(const std::string& sensor, const std::string& chosen, double budget_us,
                                     const WorkPrecision& work_precision);

}  // namespace slipd
