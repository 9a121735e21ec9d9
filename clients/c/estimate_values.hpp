// An estimate as slipd sends it on the socket (docs/socket.md), in the socket's units. Any one thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "clients/c/connection.hpp"

namespace slipd::client {

// Unknown numbers are absent.
struct EstimateValues {
  std::string name;                             // of the sensor or grasp
  std::string state = "stale";                  // ok, no_contact, learning …
  std::string alert = "unknown";                // none, warn, slip or unknown
  std::string alert_cause;                      // margin or sliding; empty: no alert or unknown
  std::string sliding;                          // none, disturbed, translation or rotation; empty: unknown
  std::string method;                           // estimation method
  std::uint64_t sequence = 0;                   // of the frame
  std::int64_t time_ns = 0;                     // of the frame, CLOCK_REALTIME; 0: there was none
  std::optional<double> gamma;                  // safety margin, 0 … 1; absent outside state ok
  std::optional<double> sigma;                  // standard deviation of gamma
  std::optional<double> gamma_low;              // the margin that holds with 95 % confidence, see socket.md
  std::optional<double> friction;               // coefficient of friction
  std::optional<double> friction_sigma;         // standard deviation of friction
  std::optional<int> slip_class;                // 1 (slip) … 5
  std::optional<double> normal_n;               // normal force, N
  std::optional<double> shear_n;                // tangential force, N
  std::optional<double> shear_x_n, shear_y_n;   // its components, N; absent of a grasp
  std::optional<double> torque_nmm;             // torque about the contact's normal, N mm
  std::optional<double> torque_sigma_nmm;       // its standard deviation, N mm
  std::optional<double> center_x_mm;            // contact centre, mm
  std::optional<double> center_y_mm;            // contact centre, mm
  std::optional<double> radius_mm;              // contact radius, mm
  std::optional<double> a_over_r;               // contact radius over the radius of curvature
  std::optional<double> time_to_slip_ms;        // at the present trend, ms
  std::optional<double> sliding_for_ms;         // how long `sliding` has been so, ms
  std::optional<double> grip_increase_n;        // advised increase of the normal force, N
  std::optional<double> grip_increase_sigma_n;  // its standard deviation, N
  std::optional<double> latency_us;             // from the frame to the estimate, us
  std::optional<double> age_ms;                 // of the frame when it was sent, ms; absent: of no frame
  std::optional<double> true_gamma;             // of a simulated sensor
  std::optional<double> true_friction;          // of a simulated sensor
  std::uint64_t dropped = 0;                    // notifications that this client lost just before this one
  bool simulated = false;
};

// Of a sensor or a grasp. A message without a state gives state fault, one without an alert gives alert slip.
EstimateValues estimate_from(const Json& message);

}  // namespace slipd::client
