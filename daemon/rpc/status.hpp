// What slipd says of itself: counts, rates, latencies, what the system granted. io thread.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "daemon/telemetry/service_context.hpp"

namespace slipd {

nlohmann::ordered_json status_json(const ServiceContext& context);

// What is known of a sensor's zero; null where its frames come zeroed.
nlohmann::ordered_json zero_json(const SensorStatus& status);

nlohmann::ordered_json sensors_json(const ServiceContext& context);

}  // namespace slipd
