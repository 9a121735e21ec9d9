#include "clients/c/estimate_values.hpp"

#include "clients/c/json_values.hpp"

namespace slipd::client {

EstimateValues estimate_from(const Json& in) {
  EstimateValues out;
  out.name = text(in, in.contains("grasp") ? "grasp" : "sensor");
  out.state = text(in, "state", "fault");
  out.alert = text(in, "alert", "slip");
  out.alert_cause = text(in, "alert_cause");
  out.sliding = text(in, "sliding");
  out.method = text(in, "method");
  out.sequence = count(in, "seq");
  out.time_ns = integer(in, "time_ns");
  out.gamma = number(in, "gamma");
  out.sigma = number(in, "sigma");
  out.gamma_low = number(in, "gamma_low");
  out.friction = number(in, "friction");
  out.friction_sigma = number(in, "friction_sigma");
  if (const auto value = number(in, "class")) out.slip_class = static_cast<int>(*value);
  out.normal_n = number(in, "normal_n");
  out.shear_n = number(in, "shear_n");
  out.shear_x_n = number(in, "shear_x_n");
  out.shear_y_n = number(in, "shear_y_n");
  out.torque_nmm = number(in, "torque_nmm");
  out.torque_sigma_nmm = number(in, "torque_sigma_nmm");
  if (const Json& center = member(in, "center_mm");
      center.is_array() && center.size() == 2 && center[0].is_number() && center[1].is_number()) {
    out.center_x_mm = center[0].get<double>();
    out.center_y_mm = center[1].get<double>();
  }
  out.radius_mm = number(in, "radius_mm");
  out.a_over_r = number(in, "a_over_r");
  out.time_to_slip_ms = number(in, "time_to_slip_ms");
  out.sliding_for_ms = number(in, "sliding_for_ms");
  out.grip_increase_n = number(in, "grip_increase_n");
  out.grip_increase_sigma_n = number(in, "grip_increase_sigma_n");
  out.latency_us = number(in, "latency_us");
  out.age_ms = number(in, "age_ms");
  out.true_gamma = number(member(in, "truth"), "gamma");
  out.true_friction = number(member(in, "truth"), "friction");
  out.dropped = count(in, "dropped");
  out.simulated = flag(in, "simulated");
  return out;
}

}  // namespace slipd::client
