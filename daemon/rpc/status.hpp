// What slipd says of itself: counts, rates, latencies, what the system granted. io thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "daemon/rpc/rpc_context.hpp"

namespace slipd {

nlohmann::ordered_json status_json(const World& world);

// The same as text for a scraper: OpenMetrics, or the older format that node_exporter reads from files.
enum class MetricsFormat : std::uint8_t { open_metrics, prometheus };
std::string metrics_text(const World& world, MetricsFormat format);

// What is known of a sensor's zero; null where its frames come zeroed.
nlohmann::ordered_json zero_json(const Panel& panel);

nlohmann::ordered_json sensors_json(const World& world);

}  // namespace slipd
