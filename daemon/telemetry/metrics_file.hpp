// Writes the metrics into a file, for a collector that reads files. The file is replaced atomically, readable
// by everybody, and removed when slipd ends. Only a file that slipd made is replaced or removed, and only a
// folder that is slipd's own, or that its owner opened to slipd, is written to.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "config/settings.hpp"
#include "daemon/telemetry/service_context.hpp"

namespace slipd {

// Why slipd does not write its metrics into `file`, for people, beginning with a verb; empty: it does.
// Refused are
//   a name that does not end in .prom;
//   what is there already and was not made by slipd: anything but a regular file with metrics of slipd, which
//     belongs to the user that slipd runs as;
//   a folder that is neither slipd's runtime or state folder or below them, nor the user's own, nor writable
//     for one of the process's groups. Root may write into any folder.
// A folder that does not exist is not refused. Called from any thread that may wait for the disk.
std::string why_no_metrics_file(const std::filesystem::path& file);

// Not thread-safe. Called from one thread: io.
class MetricsFile {
 public:
  explicit MetricsFile(const MetricsSettings& settings) : settings_(settings) {}
  // Removes the file, if it is still the one that was written last.
  ~MetricsFile();
  MetricsFile(const MetricsFile&) = delete;
  MetricsFile& operator=(const MetricsFile&) = delete;

  // Writes the file if the period has passed. To be called at least once a second. A failure is logged once,
  // until a write succeeds again.
  void write_if_due(const ServiceContext& context, std::chrono::steady_clock::time_point now);

 private:
  std::string replace(const std::string& text);
  const MetricsSettings settings_;
  std::chrono::steady_clock::time_point due_{};
  std::optional<std::pair<dev_t, ino_t>> written_;  // identity of the file written last
  bool refused_ = false;
};

}  // namespace slipd
