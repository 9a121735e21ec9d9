// Writes the metrics into a file, for a collector that reads files. The file is replaced atomically, readable
// by everybody, and removed when slipd ends.
#pragma once

#include <chrono>

#include "config/settings.hpp"
#include "daemon/telemetry/service_context.hpp"

namespace slipd {

// Not thread-safe. Called from one thread: io.
class MetricsFile {
 public:
  explicit MetricsFile(const MetricsSettings& settings) : settings_(settings) {}
  // Removes the file.
  ~MetricsFile();
  MetricsFile(const MetricsFile&) = delete;
  MetricsFile& operator=(const MetricsFile&) = delete;

  // Writes the file if the period has passed. To be called at least once a second. A failure is logged once,
  // until a write succeeds again.
  void write_if_due(const ServiceContext& context, std::chrono::steady_clock::time_point now);

 private:
  const MetricsSettings settings_;
  std::chrono::steady_clock::time_point due_{};
  bool refused_ = false;
};

}  // namespace slipd
