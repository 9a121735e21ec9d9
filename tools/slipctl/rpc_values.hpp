// What the daemon tells, as plain values: sensors, estimates, frames, counts. Lenient in what is missing or
// null (an older daemon, an unknown number), for a tool that watches should show what there is.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace slipctl {

struct SensorInfo {
  std::string name, driver, sensor_class, method;
  std::size_t taxels = 0;
  double rate_hz = 0;
  bool simulated = false;
  bool connected = false;
};

// One estimate; units as on the socket, an unknown number is absent.
struct EstimateView {
  std::string sensor;
  std::string state = "stale";
  std::string alert = "none";
  std::string method;
  std::uint64_t sequence = 0;
  std::int64_t time_ns = 0;  // CLOCK_REALTIME of the sample
  std::optional<double> gamma, sigma, friction, friction_sigma;
  std::optional<int> slip_class;
  std::optional<double> normal_n, shear_n, center_x_mm, center_y_mm, radius_mm, a_over_r;
  std::optional<double> time_to_slip_ms, grip_increase_n, latency_us, age_ms;
  std::optional<double> true_gamma, true_friction;
  std::uint64_t dropped = 0;  // notifications lost for us just before this one
  bool simulated = false;
};

// All vectors have the same length: taxels.
struct TaxelFrame {
  std::uint64_t sequence = 0;
  std::int64_t time_ns = 0;
  std::vector<double> normal_pa, shear_x_pa, shear_y_pa, x_mm, y_mm;
};

struct SensorCounts {
  std::string name;
  std::uint64_t received = 0, estimated = 0, skipped = 0, corrupt = 0, gaps = 0, reconnects = 0;
  std::optional<double> rate_hz;
  std::optional<double> latency_p50_us, latency_p99_us, latency_p999_us, latency_max_us;
};

std::vector<SensorInfo> sensors_from(const nlohmann::ordered_json& result);  // of `sensors`
EstimateView estimate_from(const nlohmann::ordered_json& estimate);          // one estimate
std::vector<EstimateView> grasps_from(
    const nlohmann::ordered_json& result);  // of `gamma`; `sensor` is the grasp's name
TaxelFrame frame_from(
    const nlohmann::ordered_json& result);  // of `frame`; throws ClientError if lengths differ
std::vector<SensorCounts> counts_from(const nlohmann::ordered_json& result);  // of `status`

}  // namespace slipctl
