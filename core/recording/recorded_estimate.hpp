// What was estimated from a frame when it was recorded, and the one table of its entries: recordings are
// written and read by it, and exported by it. This room does not include estimate, so that names of states
// and the like are numbers here. Any thread.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "core/frame/frame.hpp"

namespace slipd {

// Unknown numbers are NaN. What an older recording does not have is unknown as well.
struct RecordedEstimate {
  // A code that is unknown.
  static constexpr std::uint8_t kNoCode = 255;

  // State of core/estimate/estimate.hpp.
  std::uint8_t state = 0;
  // Alert of core/estimate/estimate.hpp.
  std::uint8_t alert = 0;
  // Safety margin, 0 to 1.
  double gamma = kUnknown;
  // Standard deviation of gamma.
  double sigma = kUnknown;
  // Friction coefficient.
  double friction = kUnknown;
  // Normal force, N.
  double normal_n = kUnknown;
  // Tangential force, N.
  double shear_n = kUnknown;
  // Sliding of core/sliding/sliding.hpp.
  std::uint8_t sliding = kNoCode;
  // AlertCause of core/estimate/estimate.hpp.
  std::uint8_t alert_cause = kNoCode;
  // Torque about the contact's normal, N m.
  double torque_nm = kUnknown;
  // The angle by which the object turned over the skin, rad.
  double turned_rad = kUnknown;
  // The margin that holds with 95 % confidence.
  double gamma_low = kUnknown;
  // Standard deviation of friction.
  double friction_sigma = kUnknown;
  // Components of shear_n along the sensor's x and y, N.
  double shear_x_n = kUnknown, shear_y_n = kUnknown;
  // Standard deviation of torque_nm, N m.
  double torque_sigma_nm = kUnknown;
  // Standard deviation of turned_rad, rad.
  double turned_sigma_rad = kUnknown;
  // The contact's centre and radius, m.
  double center_x_m = kUnknown, center_y_m = kUnknown, radius_m = kUnknown;
  // The contact's radius over the skin's.
  double a_over_r = kUnknown;
  // Forecast, s.
  double time_to_slip_s = kUnknown;
  // Normal force to add for the target margin, N, and its standard deviation, N.
  double grip_increase_n = kUnknown, grip_increase_sigma_n = kUnknown;
  // How long `sliding` has been what it is, s.
  double sliding_for_s = kUnknown;
  // Method of core/estimate/estimate.hpp.
  std::uint8_t method = kNoCode;
  // Health of core/health/health.hpp.
  std::uint8_t health = kNoCode;

  // Whether it has all that was estimated; else it is of a recording from before gamma_low and what follows.
  constexpr bool is_whole() const noexcept { return method != kNoCode; }
};

// An entry in a recording: either a number or a code.
struct RecordedEntry {
  // Its name; that of a number ends with the unit.
  std::string_view key;
  double RecordedEstimate::*number;
  std::uint8_t RecordedEstimate::*code;

  constexpr RecordedEntry(std::string_view name, double RecordedEstimate::*member)
      : key(name), number(member), code(nullptr) {}
  constexpr RecordedEntry(std::string_view name, std::uint8_t RecordedEstimate::*member)
      : key(name), number(nullptr), code(member) {}
};

// In the order in recordings. An older recording has the first entries only, so that new ones are added at
// the end.
inline constexpr std::array kRecordedEntries{
    RecordedEntry{"state", &RecordedEstimate::state},
    RecordedEntry{"alert", &RecordedEstimate::alert},
    RecordedEntry{"gamma", &RecordedEstimate::gamma},
    RecordedEntry{"sigma", &RecordedEstimate::sigma},
    RecordedEntry{"friction", &RecordedEstimate::friction},
    RecordedEntry{"normal_n", &RecordedEstimate::normal_n},
    RecordedEntry{"shear_n", &RecordedEstimate::shear_n},
    RecordedEntry{"sliding", &RecordedEstimate::sliding},
    RecordedEntry{"alert_cause", &RecordedEstimate::alert_cause},
    RecordedEntry{"torque_nm", &RecordedEstimate::torque_nm},
    RecordedEntry{"turned_rad", &RecordedEstimate::turned_rad},
    RecordedEntry{"gamma_low", &RecordedEstimate::gamma_low},
    RecordedEntry{"friction_sigma", &RecordedEstimate::friction_sigma},
    RecordedEntry{"shear_x_n", &RecordedEstimate::shear_x_n},
    RecordedEntry{"shear_y_n", &RecordedEstimate::shear_y_n},
    RecordedEntry{"torque_sigma_nm", &RecordedEstimate::torque_sigma_nm},
    RecordedEntry{"turned_sigma_rad", &RecordedEstimate::turned_sigma_rad},
    RecordedEntry{"center_x_m", &RecordedEstimate::center_x_m},
    RecordedEntry{"center_y_m", &RecordedEstimate::center_y_m},
    RecordedEntry{"radius_m", &RecordedEstimate::radius_m},
    RecordedEntry{"a_over_r", &RecordedEstimate::a_over_r},
    RecordedEntry{"time_to_slip_s", &RecordedEstimate::time_to_slip_s},
    RecordedEntry{"grip_increase_n", &RecordedEstimate::grip_increase_n},
    RecordedEntry{"grip_increase_sigma_n", &RecordedEstimate::grip_increase_sigma_n},
    RecordedEntry{"sliding_for_s", &RecordedEstimate::sliding_for_s},
    RecordedEntry{"method", &RecordedEstimate::method},
    RecordedEntry{"health", &RecordedEstimate::health},
};
// Entries of the oldest recordings with estimates.
inline constexpr std::size_t kFewestRecordedEntries = 7;

}  // namespace slipd
