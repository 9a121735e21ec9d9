// The daemon's JSON as plain values: sensors, estimates, frames, counts. A missing or null key (an older
// daemon, an unknown number) gives an absent value, not an error, so that slipctl shows what is known.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace slipctl {

struct SensorInfo {
  std::string name;
  std::string driver;
  std::string sensor_class;  // array3, wrench or normal
  std::string method;        // estimation method
  std::size_t taxels = 0;
  double rate_hz = 0;  // frames per second; 0: unknown
  bool simulated = false;
  bool connected = false;
};

// One estimate as docs/socket.md describes it. Unknown numbers are absent.
struct EstimateView {
  std::string sensor;                      // name of the sensor or grasp
  std::string state = "stale";             // ok, no_contact, learning …
  std::string alert = "none";              // none, warn or slip
  std::string alert_cause;                 // margin or sliding; empty: no alert
  std::string sliding;                     // none, disturbed, translation or rotation; empty: unknown
  std::string method;                      // estimation method
  std::uint64_t sequence = 0;              // of the frame
  std::int64_t time_ns = 0;                // of the frame, CLOCK_REALTIME
  std::optional<double> gamma;             // safety margin, 0 … 1; absent outside state ok
  std::optional<double> sigma;             // standard deviation of gamma
  std::optional<double> friction;          // coefficient of friction
  std::optional<double> friction_sigma;    // standard deviation of friction
  std::optional<int> slip_class;           // 1 (slip) … 5
  std::optional<double> normal_n;          // normal force, N
  std::optional<double> shear_n;           // tangential force, N
  std::optional<double> torque_nmm;        // torque about the contact's normal, N mm
  std::optional<double> torque_sigma_nmm;  // its standard deviation, N mm
  std::optional<double> center_x_mm;       // contact centre, mm
  std::optional<double> center_y_mm;       // contact centre, mm
  std::optional<double> radius_mm;         // contact radius, mm
  std::optional<double> a_over_r;          // contact radius over the radius of curvature
  std::optional<double> time_to_slip_ms;   // at the present trend, ms
  std::optional<double> sliding_for_ms;    // how long `sliding` has been so, ms
  std::optional<double> grip_increase_n;   // advised increase of the normal force, N
  std::optional<double> latency_us;        // from the frame to the estimate, us
  std::optional<double> age_ms;            // of the frame when it was sent, ms
  std::optional<double> true_gamma;        // of a simulated sensor
  std::optional<double> true_friction;     // of a simulated sensor
  std::uint64_t dropped = 0;               // notifications that this client lost just before this one
  bool simulated = false;
};

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

std::vector<SensorInfo> sensors_from(const nlohmann::ordered_json& result);  // of `sensors`
EstimateView estimate_from(const nlohmann::ordered_json& estimate);          // one estimate
std::vector<EstimateView> grasps_from(
    const nlohmann::ordered_json& result);  // of `gamma`; `sensor` is the grasp's name
TaxelFrame frame_from(
    const nlohmann::ordered_json& result);  // of `frame`; throws ClientError if lengths differ
std::vector<SensorCounts> counts_from(const nlohmann::ordered_json& result);  // of `status`

}  // namespace slipctl
