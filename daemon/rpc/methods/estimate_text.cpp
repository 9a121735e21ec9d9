#include "daemon/rpc/methods/estimate_text.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "daemon/rpc/protocol/text.hpp"

namespace slipd {
namespace {

constexpr double kDegPerRad = 180 / std::numbers::pi;

std::optional<std::int64_t> class_of(std::optional<double> gamma) {
  if (!gamma || !std::isfinite(*gamma)) return std::nullopt;
  return slip_class(std::clamp(*gamma, 0.0, 1.0));
}

// At least 0: the clock of a recording may be ahead.
std::int64_t passed_ns(std::int64_t since_ns, std::int64_t until_ns) {
  return std::max<std::int64_t>(0, until_ns - since_ns);
}

// Of sensors of displacements and their grasps; others have no such entries.
void add_displacement(ObjectText& object, const Estimate& estimate) {
  if (!estimate.slide_evidence) return;
  object.number("displacement_mm", estimate.displacement_m, 1e3);
  if (estimate.contact) {
    object.boolean("contact", *estimate.contact);
  } else {
    object.begin("contact") += "null";
  }
  object.number("slide_evidence", estimate.slide_evidence);
}

// A name, or null.
void add_name(ObjectText& object, std::string_view key, std::optional<std::string_view> name) {
  if (name) {
    object.text(key, *name);
  } else {
    object.begin(key) += "null";
  }
}

void add_sliding(ObjectText& object, const Estimate& estimate) {
  const bool caused = estimate.alert_cause != AlertCause::none;
  add_name(object, "alert_cause", caused ? std::optional(to_string(estimate.alert_cause)) : std::nullopt);
  add_name(object, "sliding", estimate.sliding ? std::optional(to_string(*estimate.sliding)) : std::nullopt);
  object.number("sliding_for_ms", estimate.sliding_for_s, 1e3);
}

}  // namespace

EstimateText::EstimateText(const Estimate& estimate, const std::string& sensor, bool simulated)
    : sequence_(estimate.sequence),
      time_ns_(estimate.time_ns),
      published_ns_(estimate.published_ns),
      state_(estimate.state),
      simulated_(simulated) {
  constexpr std::size_t kUsualBytes = 888;
  const bool answered = time_ns_ != 0 && estimate.state != State::stale && estimate.state != State::fault;
  const auto gamma = estimate.state == State::ok ? estimate.gamma : std::nullopt;
  text_.reserve(kUsualBytes);
  ObjectText object(text_);
  object.text("sensor", sensor).integer("seq", static_cast<std::int64_t>(estimate.sequence));
  time_at_ = object.begin("time_ns").size();
  object.text("state", to_string(estimate.state))
      .number("gamma", gamma)
      .number("sigma", estimate.sigma)
      .integer("class", class_of(gamma))
      .number("gamma_low", estimate.gamma_low)
      .number("friction", estimate.friction)
      .number("friction_sigma", estimate.friction_sigma)
      .number("normal_n", estimate.normal_n)
      .number("shear_n", estimate.shear_n)
      .number("shear_x_n", estimate.shear_x_n)
      .number("shear_y_n", estimate.shear_y_n)
      .number("torque_nmm", estimate.torque_nm, 1e3)
      .number("torque_sigma_nmm", estimate.torque_sigma_nm, 1e3)
      .number("turned_deg", estimate.turned_rad, kDegPerRad)
      .number("turned_sigma_deg", estimate.turned_sigma_rad, kDegPerRad);
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
      .text("alert", to_string(estimate.alert));
  add_sliding(object, estimate);
  add_displacement(object, estimate);
  object.text("method", to_string(estimate.method))
      .text("health", to_string(estimate.health))
      .boolean("simulated", simulated)
      .number("latency_us",
              answered ? std::optional<double>(passed_ns(time_ns_, published_ns_)) : std::nullopt, 1e-3);
  age_at_ = object.begin("age_ms").size();
  if (simulated) {
    ObjectText truth(object.begin("truth"));
    truth.number("gamma", estimate.truth.gamma).number("friction", estimate.truth.friction).end();
  }
  object.end();
}

bool EstimateText::is_of(const Estimate& estimate, bool simulated) const noexcept {
  return !text_.empty() && published_ns_ == estimate.published_ns && sequence_ == estimate.sequence &&
         time_ns_ == estimate.time_ns && state_ == estimate.state && simulated_ == simulated;
}

void EstimateText::append_to(std::string& out, const Now& now) const {
  const bool sampled = time_ns_ != 0;
  out.append(text_, 0, time_at_);
  append_integer(out, sampled ? std::optional(now.realtime_of(time_ns_)) : std::nullopt);
  out.append(text_, time_at_, age_at_ - time_at_);
  if (sampled) {
    append_ms(out, passed_ns(time_ns_, now.monotonic_ns));
  } else {
    out += "null";
  }
  out.append(text_, age_at_);
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
      .number("gamma_low", together.gamma_low)
      .number("friction", together.friction)
      .number("friction_sigma", together.friction_sigma)
      .number("normal_n", together.normal_n)
      .number("shear_n", together.shear_n)
      .number("time_to_slip_ms", together.time_to_slip_s, 1e3)
      .number("grip_increase_n", together.grip_increase_n)
      .number("grip_increase_sigma_n", together.grip_increase_sigma_n)
      .text("alert", to_string(together.alert));
  add_sliding(object, together);
  add_displacement(object, together);
  std::string& first = object.begin("first");
  if (together.first_gamma && together.first_member < sensors.size()) {
    ObjectText finger(first);
    finger.text("sensor", sensors[together.first_member]).number("gamma", together.first_gamma).end();
  } else {
    first += "null";
  }
  object.end();
}

}  // namespace slipd
