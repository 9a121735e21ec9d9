// What slipd says of itself: counts, rates, latencies, what the system granted. io thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "daemon/serve/world.hpp"

namespace slipd {

nlohmann::ordered_json status_json(const World& world);

// The same as OpenMetrics text, for a scraper.
std::string metrics_text(const World& world);

// What is known of a sensor's zero; null where its frames come zeroed.
nlohmann::ordered_json zero_json(const Panel& panel);

nlohmann::ordered_json sensors_json(const World& world);

}  // namespace slipd
