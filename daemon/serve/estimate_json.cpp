#include "daemon/serve/estimate_json.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

namespace slipd {
namespace {

using json = nlohmann::ordered_json;

json number(std::optional<double> value, double factor = 1) {
  return value && std::isfinite(*value) ? json(*value * factor) : json(nullptr);
}

}  // namespace

json estimate_json(const Estimate& estimate, const std::string& sensor, bool simulated, const Now& now) {
  const bool sampled = estimate.time_ns != 0;
  const bool answered = estimate.state != State::stale && estimate.state != State::fault;
  json result{{"sensor", sensor},
              {"seq", estimate.sequence},
              {"time_ns", sampled ? json(now.realtime_of(estimate.time_ns)) : json(nullptr)},
              {"state", to_string(estimate.state)},
              {"gamma", estimate.state == State::ok ? number(estimate.gamma) : json(nullptr)},
              {"sigma", number(estimate.sigma)},
              {"class", nullptr},
              {"friction", number(estimate.friction)},
              {"friction_sigma", number(estimate.friction_sigma)},
              {"normal_n", number(estimate.normal_n)},
              {"shear_n", number(estimate.shear_n)},
              {"center_mm", nullptr},
              {"radius_mm", number(estimate.radius_m, 1e3)},
              {"a_over_r", number(estimate.a_over_r)},
              {"time_to_slip_ms", number(estimate.time_to_slip_s, 1e3)},
              {"grip_increase_n", number(estimate.grip_increase_n)},
              {"grip_increase_sigma_n", number(estimate.grip_increase_sigma_n)},
              {"alert", to_string(estimate.alert)},
              {"method", to_string(estimate.method)},
              {"simulated", simulated},
              {"latency_us", nullptr},
              {"age_ms", nullptr}};
  if (result["gamma"].is_number()) result["class"] = slip_class(std::clamp(*estimate.gamma, 0.0, 1.0));
  if (estimate.center_x_m && estimate.center_y_m) {
    result["center_mm"] = {number(estimate.center_x_m, 1e3), number(estimate.center_y_m, 1e3)};
  }
  if (sampled) {
    // A recording's clock may run ahead of ours: then it has no age.
    const auto since = [&](std::int64_t later) {
      return std::max<std::int64_t>(0, later - estimate.time_ns);
    };
    result["age_ms"] = static_cast<double>(since(now.monotonic_ns)) * 1e-6;
    if (answered) result["latency_us"] = static_cast<double>(since(estimate.published_ns)) * 1e-3;
  }
  if (simulated) {
    result["truth"] = {{"gamma", number(estimate.truth.gamma)},
                       {"friction", number(estimate.truth.friction)}};
  }
  return result;
}

json grasp_json(const Estimate& together, const std::string& name, const std::vector<std::string>& sensors) {
  json result{{"grasp", name},
              {"sensors", sensors},
              {"state", to_string(together.state)},
              {"gamma", number(together.gamma)},
              {"sigma", number(together.sigma)},
              {"class", nullptr},
              {"friction", number(together.friction)},
              {"friction_sigma", number(together.friction_sigma)},
              {"normal_n", number(together.normal_n)},
              {"shear_n", number(together.shear_n)},
              {"time_to_slip_ms", number(together.time_to_slip_s, 1e3)},
              {"grip_increase_n", number(together.grip_increase_n)},
              {"grip_increase_sigma_n", number(together.grip_increase_sigma_n)},
              {"alert", to_string(together.alert)}};
  if (together.gamma) result["class"] = slip_class(*together.gamma);
  return result;
}

}  // namespace slipd
