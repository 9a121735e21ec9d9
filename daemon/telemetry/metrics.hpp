// slipd's metrics as text for a scraper.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/telemetry/service_context.hpp"

namespace slipd {

enum class MetricsFormat : std::uint8_t {
  open_metrics,  // OpenMetrics 1.0
  prometheus     // the older text format, which node_exporter reads from files
};

// All metrics. Called from one thread: io.
std::string metrics_text(const ServiceContext& context, MetricsFormat format);

}  // namespace slipd
