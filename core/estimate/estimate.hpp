// The estimate of one frame. Trivially copyable, so that it crosses threads by plain copies.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>

#include "core/frame/frame.hpp"
#include "core/health/health.hpp"
#include "core/sliding/sliding.hpp"

namespace slipd {

// Fail safe: gamma is a number only in state ok. The order is that of the CAN signal `State`.
enum class State : std::uint8_t { ok, no_contact, learning, out_of_model, no_shear, unzeroed, stale, fault };
enum class Alert : std::uint8_t {
  none,    // something was there to raise one, and did not
  warn,    // the margin is small
  slip,    // the object slides, or is about to
  unknown  // nothing was there to raise one: no frames, or neither a margin nor a pattern that shows slides
};

// Whether it is one that a controller acts on.
constexpr bool is_raised(Alert alert) noexcept {
  return alert == Alert::warn || alert == Alert::slip;
}
// What is known of an alert once frames have ended: one that was raised stands, as nobody saw the grip get
// safer; that there was none is known no longer.
constexpr Alert without_frames(Alert last) noexcept {
  return is_raised(last) ? last : Alert::unknown;
}

// What an alert comes from.
enum class AlertCause : std::uint8_t {
  none,    // there is no alert
  margin,  // the margin is below a threshold
  sliding  // the object is seen to slide; the alert is slip
};
enum class Method : std::uint8_t {
  none,
  svd_knn,
  registered,
  moments,
  fit,
  friction,
  closing,
  block_fit,
  displacement
};  // friction: 1 - (Q/P)/mu; displacement: slides only, never a margin

std::string_view to_string(State) noexcept;       // as on the socket: "ok", "no_contact", …
std::string_view to_string(Alert) noexcept;       // "none", "warn", "slip", "unknown"
std::string_view to_string(AlertCause) noexcept;  // "none", "margin", "sliding"
std::string_view to_string(Method) noexcept;      // "svd-knn", "registered", …

// Lengths in metres, forces in newtons, an absent value is unknown.
struct Estimate {
  std::uint64_t sequence = 0;
  std::int64_t time_ns = 0;       // of the sample, CLOCK_MONOTONIC
  std::int64_t published_ns = 0;  // when the board got it, CLOCK_MONOTONIC
  std::optional<double> gamma;    // safety margin, 1 no tangential load … 0 gross slip
  std::optional<double> sigma;    // standard deviation of gamma
  // Coefficient of friction and its standard deviation; none until it was learnt from frames, unless a value
  // was given.
  std::optional<double> friction, friction_sigma;
  std::optional<double> normal_n, shear_n;
  // The components of shear_n along the sensor's x and y, N. None in a grasp's estimate.
  std::optional<double> shear_x_n, shear_y_n;
  std::optional<double> center_x_m, center_y_m, radius_m;
  std::optional<double>
      a_over_r;  // radius over the skin's: contact models hold where it is small; flat: none
  std::optional<double> time_to_slip_s;
  std::optional<double> grip_increase_n, grip_increase_sigma_n;
  // The margin that holds with 95 % confidence while friction stays, 0 to 1: with what was learnt of
  // friction, else with the low end of the range that was given or that the scene expects. Also in learning
  // and out_of_model. None without contact and without known forces.
  std::optional<double> gamma_low;
  // The tangential force that the contact can carry, mu P, by what is known of friction: with its standard
  // deviation, in state ok; and what it is not below with 95 % confidence, in every state with contact and
  // known forces. N. A margin before friction is learnt needs it as well. For grasps; clients do not get it.
  std::optional<double> limit_n, limit_sigma_n, limit_low_n;
  // Of a grasp: the least margin of its fingers, that of the one that slides first, and which that is, in the
  // order of its sensors. None in a sensor's estimate.
  std::optional<double> first_gamma;
  std::uint8_t first_member = 0;
  // Torque about the contact's normal, through its centre, on the sensor, N m, positive from x to y; and its
  // standard deviation, N m. None where the sensor measures none.
  std::optional<double> torque_nm, torque_sigma_nm;
  // The angle by which the object turned over the skin since the contact settled, rad, positive from x to y,
  // and its standard deviation, rad. The elastic twist of a contact that sticks is not in it. None where the
  // pressure has no direction that would turn with the object. For sensors, not for grasps.
  std::optional<double> turned_rad, turned_sigma_rad;
  // The pull without torque that is as near to slip as shear_n and torque_nm together, N; shear_n where noise
  // may be all of the torque. gamma = 1 - pull_n/(friction normal_n).
  std::optional<double> pull_n;
  // Whether the object slides now; none: this sensor or contact cannot show it.
  std::optional<Sliding> sliding;
  // How long `sliding` has been what it is, s; none if it is.
  std::optional<double> sliding_for_s;
  // What the pattern shows beside that. For grasps; clients do not get it.
  std::optional<PatternCourse> pattern;
  // Of sensors of displacements and their grasps; none for others. How far the surface is from its place at
  // rest: root mean square over the points that are seen, m. Of a grasp: the most of its fingers'.
  std::optional<double> displacement_m;
  // Whether something touches the surface. Of a grasp: any of its fingers.
  std::optional<bool> contact;
  // How much this frame and those before it speak for a slide, nats, >= 0 (docs/displacement.md). Of a grasp:
  // the most of its fingers'.
  std::optional<double> slide_evidence;
  Truth truth;
  State state = State::stale;
  Alert alert = Alert::unknown;
  AlertCause alert_cause = AlertCause::none;
  Method method = Method::none;
  // What speaks against this frame; a gamma beside another health than `good` uses the remaining
  // taxels. `unknown`: no frame was checked.
  Health health = Health::unknown;
};
static_assert(std::is_trivially_copyable_v<Estimate>);

// The five classes of docs/theory.md §1.1: 1 for Gamma in 0–0.2 … 5 for 0.8–1. gamma in [0, 1].
constexpr int slip_class(double gamma) noexcept {
  return std::min(4, static_cast<int>(5 * gamma)) + 1;
}

}  // namespace slipd
