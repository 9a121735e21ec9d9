// What slipd measures of itself, as text for a scraper. io thread.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/telemetry/service_context.hpp"

namespace slipd {

// OpenMetrics, or the older format that node_exporter reads from files.
enum class MetricsFormat : std::uint8_t { open_metrics, prometheus };

std::string metrics_text(const ServiceContext& context, MetricsFormat format);

}  // namespace slipd
