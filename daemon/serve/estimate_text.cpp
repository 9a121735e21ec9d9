#include "daemon/serve/estimate_text.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "daemon/serve/text.hpp"

namespace slipd {
namespace {

std::optional<std::int64_t> class_of(std::optional<double> gamma) {
  if (!gamma || !std::isfinite(*gamma)) return std::nullopt;
  return slip_class(std::clamp(*gamma, 0.0, 1.0));
}

}  // namespace

void append_estimate(std::string& out, const Estimate& estimate, const std::string& sensor, bool simulated,
                     const Now& now) {
  const bool sampled = estimate.time_ns != 0;
  const bool answered = estimate.state != State::stale && estimate.state != State::fault;
  const auto gamma = estimate.state == State::ok ? estimate.gamma : std::nullopt;
  // A recording's clock may run ahead of ours: then it has no age.
  const auto since = [&](std::int64_t later, double unit) {
    return static_cast<double>(std::max<std::int64_t>(0, later - estimate.time_ns)) * unit;
  };
  const auto when = [](bool known, auto value) { return known ? std::optional(value) : std::nullopt; };
  ObjectText object(out);
  object.text("sensor", sensor)
      .integer("seq", static_cast<std::int64_t>(estimate.sequence))
      .integer("time_ns", when(sampled, now.realtime_of(estimate.time_ns)))
      .text("state", to_string(estimate.state))
      .number("gamma", gamma)
      .number("sigma", estimate.sigma)
      .integer("class", class_of(gamma))
      .number("friction", estimate.friction)
      .number("friction_sigma", estimate.friction_sigma)
      .number("normal_n", estimate.normal_n)
      .number("shear_n", estimate.shear_n);
  std::string& center = object.begin("center_mm");
  if (estimate.center_x_m && estimate.center_y_m) {
    center += '[';
    append_number(center, *estimate.center_x_m * 1e3);
    center += ',';
    append_number(center, *estimate.center_y_m * 1e3);
    center += ']';
  } else {
    center += "null";
  }
  object.number("radius_mm", estimate.radius_m, 1e3)
      .number("a_over_r", estimate.a_over_r)
      .number("time_to_slip_ms", estimate.time_to_slip_s, 1e3)
      .number("grip_increase_n", estimate.grip_increase_n)
      .number("grip_increase_sigma_n", estimate.grip_increase_sigma_n)
      .text("alert", to_string(estimate.alert))
      .text("method", to_string(estimate.method))
      .boolean("simulated", simulated)
      .number("latency_us", when(sampled && answered, since(estimate.published_ns, 1e-3)))
      .number("age_ms", when(sampled, since(now.monotonic_ns, 1e-6)));
  if (simulated) {
    ObjectText truth(object.begin("truth"));
    truth.number("gamma", estimate.truth.gamma).number("friction", estimate.truth.friction).end();
  }
  object.end();
}

void append_grasp(std::string& out, const Estimate& together, const std::string& name,
                  const std::vector<std::string>& sensors) {
  ObjectText object(out);
  object.text("grasp", name);
  std::string& names = object.begin("sensors");
  names += '[';
  for (const std::string& sensor : sensors) {
    if (&sensor != sensors.data()) names += ',';
    append_text(names, sensor);
  }
  names += ']';
  object.text("state", to_string(together.state))
      .number("gamma", together.gamma)
      .number("sigma", together.sigma)
      .integer("class", class_of(together.gamma))
      .number("friction", together.friction)
      .number("friction_sigma", together.friction_sigma)
      .number("normal_n", together.normal_n)
      .number("shear_n", together.shear_n)
      .number("time_to_slip_ms", together.time_to_slip_s, 1e3)
      .number("grip_increase_n", together.grip_increase_n)
      .number("grip_increase_sigma_n", together.grip_increase_sigma_n)
      .text("alert", to_string(together.alert))
      .end();
}

}  // namespace slipd
