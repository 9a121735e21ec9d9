#include "drivers/sim/options.hpp"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "embedded/sim_options.hpp"

namespace slipd::sim {
namespace {

using nlohmann::json;

// An object with the defaults of its schema where it says nothing.
json filled(json value, const json& schema) {
  if (!value.is_object()) value = json::object();
  for (const auto& [key, property] : schema.at("properties").items()) {
    if (!value.contains(key) && property.contains("default")) value[key] = property["default"];
    if (value.contains(key) && property.value("type", "") == "object")
      value[key] = filled(value[key], property);
  }
  return value;
}

std::optional<Ramp> ramp(const json& phase, const char* key) {
  const auto found = phase.find(key);
  if (found == phase.end()) return std::nullopt;
  if (found->is_number()) return Ramp{found->get<double>(), found->get<double>()};
  return Ramp{found->at(0).get<double>(), found->at(1).get<double>()};
}

Phase phase_of(const json& item) {
  Phase phase;
  phase.duration_ns = std::llround(item.at("ms").get<double>() * 1e6);
  phase.normal_n = ramp(item, "normal_n");
  phase.shear_n = ramp(item, "shear_n");
  phase.load = ramp(item, "load");
  phase.torque_nm = ramp(item, "torque_nmm");
  if (phase.torque_nm) {
    phase.torque_nm->from *= 1e-3;
    phase.torque_nm->to *= 1e-3;
  }
  if (item.contains("friction")) phase.friction = item["friction"].get<double>();
  return phase;
}

Options options_of(const SensorSetup& sensor) {
  const json options = filled(sensor.options, json::parse(sim_options));
  Options out;
  auto& s = out.sensor;
  s.skin = {sensor.skin_radius_m, sensor.skin_modulus_pa, sensor.skin_poisson};
  const auto& object = options.at("object");
  const auto& radius = object.at("radius_mm");
  s.object.radius_m =
      radius.is_string() ? std::numeric_limits<double>::infinity() : 1e-3 * radius.get<double>();
  s.object.modulus_pa = 1e6 * object.at("modulus_mpa").get<double>();
  s.object.poisson = object.at("poisson").get<double>();
  s.imprint = {
      .depth_m = sensor.skin_depth_m,
      .bonded_poisson = Skin{.poisson = sensor.skin_poisson, .base = sensor.skin_base}.bonded_poisson(),
      .stretch = object.at("axes").get<double>(),
      .angle_rad = object.at("angle_deg").get<double>() * std::numbers::pi / 180,
      .power = object.at("profile").get<double>()};
  s.offset_x_m = 1e-3 * options.at("offset_mm").at(0).get<double>();
  s.offset_y_m = 1e-3 * options.at("offset_mm").at(1).get<double>();
  s.lever_m = 1e-3 * options.at("lever_mm").get<double>();
  s.preset = preset_of(options.at("preset").get<std::string>()).value();
  for (const auto& phase : options.at("cycle")) s.cycle.push_back(phase_of(phase));
  auto& i = s.imperfections;
  i.seed = options.at("seed").get<std::uint64_t>();
  i.noise = options.at("noise").get<double>();
  i.noise_kind = options.at("noise_kind") == "relative" ? NoiseKind::relative : NoiseKind::sensor;
  i.full_scale_pa = 1e3 * options.at("full_scale_kpa").get<double>();
  i.drop = options.at("drop").get<double>();
  i.late_ms = options.at("late_ms").get<double>();
  i.dead = options.at("dead").get<double>();
  i.gain_spread = options.at("gain_spread").get<double>();
  i.zero_spread_pa = 1e3 * options.at("zero_spread_kpa").get<double>();
  i.drift_pa_s = 1e3 * options.at("drift_kpa_s").get<double>();
  out.zeroed = options.at("zeroed").get<bool>();
  out.grip_input = options.value("grip_input", "");
  out.in_real_time = options.at("speed") != 0;
  return out;
}

}  // namespace

Options parse_options(const SensorSetup& sensor) {
  const std::string who = "sensor \"" + sensor.name + "\": simulated sensor: ";
  try {
    Options options = options_of(sensor);
    if (!options.in_real_time && !options.grip_input.empty())
      throw DriverError(who +
                        "grip_input needs speed 1: at speed 0 no frame waits for the controller's answer");
    static_cast<void>(Script(options.sensor.cycle));
    if (options.sensor.preset == Preset::ideal)
      static_cast<void>(contact::make_body_pair(options.sensor.skin, options.sensor.object));
    else if (sensor.layout.size() == 1)
      throw DriverError(who + "preset " + std::string(to_string(options.sensor.preset)) +
                        " needs a layout of several taxels; one force vector has preset ideal");
    const bool shaped = options.sensor.imprint.stretch != 1 || options.sensor.imprint.power != 2;
    if (shaped && (options.sensor.preset != Preset::ideal || sensor.layout.size() == 1))
      throw DriverError(who +
                        "object.axes and object.profile need preset ideal and a layout of several taxels");
    if (options.sensor.preset != Preset::ideal && sensor.skin_depth_m > 0 &&
        sensor.skin_base != SkinBase::half_space)
      throw DriverError(who + "skin.base rigid needs preset ideal: the skins of others are half spaces");
    if (turns(options.sensor) && !options.sensor.imprint.plain())
      throw DriverError(
          who + "torque_nmm and lever_mm need a round contact and taxels at the surface (skin.depth_mm 0)");
    if (turns(options.sensor) && (options.sensor.preset != Preset::ideal || sensor.layout.size() == 1))
      throw DriverError(who +
                        "torque_nmm and lever_mm need preset ideal and a layout of several taxels: "
                        "others sense no torque");
    return options;
  } catch (const contact::ContactError& e) {
    throw DriverError(
        who + e.what() +
        ": a flat skin needs a round object (options: object.radius_mm), a hollow object a narrower skin");
  } catch (const json::exception& e) {
    throw DriverError(who + "its options do not fit their schema: " + e.what());
  } catch (const std::invalid_argument& e) {
    throw DriverError(who + e.what());
  }
}

}  // namespace slipd::sim
