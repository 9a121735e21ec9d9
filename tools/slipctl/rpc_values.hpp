// The daemon's JSON as plain values: sensors, grasps, frames, counts. A missing or null key (an older daemon,
// an unknown number) gives an absent value, not an error, so that slipctl shows what is known.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "clients/c/estimate_values.hpp"

namespace slipctl {

struct SensorInfo {
  std::string name;
  std::string driver;
  std::string sensor_class;  // array3, wrench, normal or displacement
  std::string method;        // estimation method
  std::size_t taxels = 0;
  double rate_hz = 0;  // frames per second; 0: unknown
  bool simulated = false;
  bool connected = false;
};

using slipd::client::estimate_from;
using slipd::client::EstimateValues;

// One frame. All vectors have one element per taxel.
struct TaxelFrame {
  std::uint64_t sequence = 0;
  std::int64_t time_ns = 0;        // CLOCK_REALTIME
  std::vector<double> normal_pa;   // pressure, Pa
  std::vector<double> shear_x_pa;  // traction along x, Pa
  std::vector<double> shear_y_pa;  // traction along y, Pa
  std::vector<double> x_mm;        // centres, mm
  std::vector<double> y_mm;        // centres, mm
};

// The daemon's counts of one sensor since its start.
struct SensorCounts {
  std::string name;
  std::uint64_t received = 0;             // frames from the driver
  std::uint64_t estimated = 0;            // frames estimated
  std::uint64_t skipped = 0;              // frames replaced by a newer one before they were estimated
  std::uint64_t corrupt = 0;              // packets or frames that the driver dropped
  std::uint64_t gaps = 0;                 // gaps in the frames' sequence
  std::uint64_t reconnects = 0;           // times that the device was opened again
  std::optional<double> rate_hz;          // measured frames per second
  std::optional<double> latency_p50_us;   // from frame to estimate, median, us
  std::optional<double> latency_p99_us;   // 99th percentile, us
  std::optional<double> latency_p999_us;  // 99.9th percentile, us
  std::optional<double> latency_max_us;   // largest, us
};

std::vector<SensorInfo> sensors_from(const nlohmann::ordered_json& result);     // of `sensors`
std::vector<EstimateValues> grasps_from(const nlohmann::ordered_json& result);  // of `gamma`
// Of `gamma`'s result what belongs to a name: a sensor with the grasps that hold by it, or a grasp. Throws
// ClientError, with the names that there are, if nothing is called so.
nlohmann::ordered_json part_of_gamma(const nlohmann::ordered_json& result, const std::string& name);
TaxelFrame frame_from(
    const nlohmann::ordered_json& result);  // of `frame`; throws ClientError if lengths differ
std::vector<SensorCounts> counts_from(const nlohmann::ordered_json& result);  // of `status`

}  // namespace slipctl
