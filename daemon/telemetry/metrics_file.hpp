// The metrics in a file, for a collector that reads files: always a whole one, readable by everybody, gone
// when slipd ends. io thread.
#pragma once

#include <chrono>

#include "config/settings.hpp"
#include "daemon/telemetry/service_context.hpp"

namespace slipd {

class MetricsFile {
 public:
  explicit MetricsFile(const MetricsSettings& settings) : settings_(settings) {}
  ~MetricsFile();  // removes it
  MetricsFile(const MetricsFile&) = delete;
  MetricsFile& operator=(const MetricsFile&) = delete;

  // Often. Writes when it is time. That it cannot is logged once, and again after it could.
  void look(const ServiceContext& context, std::chrono::steady_clock::time_point now);

 private:
  const MetricsSettings settings_;
  std::chrono::steady_clock::time_point due_{};
  bool refused_ = false;
};

}  // namespace slipd
