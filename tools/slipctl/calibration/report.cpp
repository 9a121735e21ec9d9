#include "tools/slipctl/calibration/report.hpp"

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

namespace slipctl::calibration {
namespace {

using Json = nlohmann::ordered_json;

// Limits of the key gain in config/slipd.schema.json.
constexpr double kLeastGain = 0.01, kGreatestGain = 100;
// Part of a force beside its axis that is worth a word: 6 degrees.
constexpr double kNotable = 0.1;

const char* const kNames[] = {"x", "y", "normal"};
const char* const kDeviceNames[] = {"x", "y", "z"};  // of a profile, and of the values that a program sends

struct NamedScale {
  std::size_t axis;  // slipd's
  AxisScale scale;
};

std::vector<NamedScale> measured(const Scales& scales) {
  std::vector<NamedScale> out{{kNormal, scales.normal}};
  if (scales.x) out.push_back({kX, *scales.x});
  if (scales.y) out.push_back({kY, *scales.y});
  return out;
}

__attribute__((format(printf, 2, 3))) void add(std::string& text, const char* format, ...) {
  char line[400];
  va_list values;
  va_start(values, format);
  std::vsnprintf(line, sizeof line, format, values);
  va_end(values);
  text += line;
}

bool is_profile_driver(const std::string& driver) {
  return driver == "can" || driver == "usb" || driver == "hid" || driver == "modbus" || driver == "serial";
}

// Whose option scale multiplies each axis.
bool has_scale_option(const std::string& driver) {
  return driver == "push" || driver == "replay";
}

void factors(std::string& text, const Scales& scales) {
  for (const auto& [axis, scale] : measured(scales)) {
    add(text, "  %-6s  factor %.4g +- %.2g", kNames[axis], scale.factor, std::max(scale.sigma, 0.0));
    if (scale.factor < 0) text += ", the sign is wrong";
    if (scale.read_on != axis) add(text, ", read on %s", kNames[scale.read_on]);
    if (scale.beside > kNotable) add(text, ", %.0f %% of it on another axis as well", 100 * scale.beside);
    text += '\n';
  }
}

void gain_line(std::string& text, const AxisScale& common) {
  if (common.factor < kLeastGain || common.factor > kGreatestGain) {
    add(text,
        "  The factor %.4g is beyond what gain takes: correct the scale in the profile or the program.\n",
        common.factor);
    return;
  }
  add(text,
      "In the configuration, at this sensor (times the gain that stands there now, 1 if there is none):\n"
      "  \"gain\": %.4g\n",
      common.factor);
}

// The values of `axes` and the factors beside each other: `sign` is "-" where the direction is reversed.
void axes_line(std::string& text, const Scales& scales) {
  std::string line;
  for (const auto& [axis, scale] : measured(scales)) {
    add(line, "%s\"%s\": \"%s%s\"", line.empty() ? "" : ", ", kNames[axis], scale.factor < 0 ? "-" : "",
        kDeviceNames[scale.read_on]);
  }
  add(text,
      "In the profile (as if it has no axes now; if it has, take what stands there for the axis that is "
      "named, "
      "and reverse it where a minus is):\n  \"axes\": { %s }\n",
      line.c_str());
}

// Values that are no forces yet become such by the profile alone: no gain makes them calibrated.
void profile_lines(std::string& text, const Subject& subject, const Scales& scales) {
  if (!scales.axes_in_place() || !scales.signs_right()) axes_line(text, scales);
  const auto common = scales.common();
  if (common && subject.zeroed) return gain_line(text, *common);
  text +=
      "In the profile, scale_pa or scale_n of the fields (device's axes, as if the profile has no axes "
      "now):\n";
  for (const auto& [axis, scale] : measured(scales))
    add(text, "  \"axis\": \"%s\": times %.4g\n", kDeviceNames[scale.read_on], std::fabs(scale.factor));
  if (!subject.zeroed) text += "  If the profile has \"calibrated\": false, take that out.\n";
}

void exchange_line(std::string& text, const std::string& driver, const Scales& scales) {
  std::string parts;
  for (const auto& [axis, scale] : measured(scales)) {
    if (scale.read_on == axis) continue;
    add(parts, "%s%s is what now is %s", parts.empty() ? "" : ", ", kDeviceNames[axis],
        kDeviceNames[scale.read_on]);
  }
  if (!parts.empty())
    add(text, "%s, first: %s.\n", driver == "push" ? "In the program that sends" : "In the file",
        parts.c_str());
}

void option_lines(std::string& text, const std::string& driver, const Scales& scales) {
  exchange_line(text, driver, scales);
  text +=
      "In the configuration, at this sensor (times the scale that stands there now, 1 if there is none):\n";
  const auto common = scales.common();
  if (common && (scales.signs_right() || !scales.x)) {
    add(text, "  \"options\": { \"scale\": %.4g }\n", std::copysign(common->factor, scales.normal.factor));
  } else {
    add(text, "  \"options\": { \"scale\": [%.4g, %.4g, %.4g] }\n", scales.x->factor, scales.y->factor,
        scales.normal.factor);
  }
}

void scale_lines(std::string& text, const Subject& subject, const Scales& scales) {
  if (is_profile_driver(subject.driver)) return profile_lines(text, subject, scales);
  if (has_scale_option(subject.driver)) return option_lines(text, subject.driver, scales);
  const auto common = scales.common();
  if (common && scales.axes_in_place() && scales.signs_right()) return gain_line(text, *common);
  add(text,
      "The configuration has no key for that: gain multiplies all axes alike. Correct the driver %s by the "
      "factors above.\n",
      subject.driver.c_str());
}

void layout_lines(std::string& text, const LayoutChange& change) {
  if (!change.any()) {
    text += "  layout  the weight is read where it lies\n";
    return;
  }
  std::string steps;
  if (change.transposed.value_or(false)) steps += "exchange x and y of each taxel";
  const auto mirror = [&](bool is, const char* axis) {
    if (is)
      add(steps, "%sreverse the sign of %s of each taxel, about the middle", steps.empty() ? "" : ", then ",
          axis);
  };
  mirror(change.mirrored_x, "x");
  mirror(change.mirrored_y, "y");
  add(text,
      "  layout  %s\n"
      "In the profile's or the configuration's layout (a grid as a list \"taxels\", in the order of the "
      "values):\n"
      "  %s\n",
      change.transposed.value_or(false) ? "transposed" : "mirrored", steps.c_str());
}

void unknown(std::string& text, const Subject& subject, const Weights& weights, const Scales& scales) {
  text += "Not known:\n";
  if (!subject.zeroed)
    text += "  the zero: slipd has none of this sensor, and tells no margin before slipctl rebias\n";
  if (!subject.pad.has_shear()) {
    text += "  shear: this sensor measures none, and slipd tells no margin of it\n";
  } else if (!scales.x) {
    text +=
        "  scale, signs and axes of shear: no weight pulled (--shear), and one factor multiplies shear, "
        "too\n";
  } else {
    text +=
        "  whether the weight pulled exactly along x and y: 6 degrees beside them are 0.5 % of the factor\n";
  }
  if (!scales.layout) {
    if (subject.pad.sensor_class != slipd::SensorClass::wrench)
      text += "  whether the layout is mirrored or transposed: --corner tells\n";
  } else if (!scales.layout->transposed) {
    text += "  whether the layout is transposed: step corner-x tells\n";
  }
  if (subject.pad.sensor_class != slipd::SensorClass::wrench)
    text += "  how the taxels differ from each other: all have one factor here\n";
  add(text, "  whether the readings are proportional to the force: one force of %.3g N was tried\n",
      weights.normal_n);
  text +=
      "  how true the weights are, and whether any of the force went past the taxels; the deviations above "
      "are those of "
      "noise alone\n";
}

Json json_of(const std::optional<AxisScale>& scale) {
  if (!scale) return nullptr;
  return {{"factor", scale->factor},
          {"sigma", scale->sigma},
          {"read_on", kNames[scale->read_on]},
          {"beside", scale->beside}};
}

}  // namespace

std::string report(const Subject& subject, const Weights& weights, const Scales& scales) {
  std::string text;
  add(text, "%s: what is read has to be multiplied by\n", subject.sensor.c_str());
  factors(text, scales);
  scale_lines(text, subject, scales);
  if (scales.layout) layout_lines(text, *scales.layout);
  unknown(text, subject, weights, scales);
  return text;
}

Json to_json(const Subject& subject, const Scales& scales) {
  Json out{{"sensor", subject.sensor},
           {"normal", json_of(scales.normal)},
           {"shear_x", json_of(scales.x)},
           {"shear_y", json_of(scales.y)},
           {"gain", nullptr},
           {"layout", nullptr}};
  if (const auto common = scales.common(); common && scales.axes_in_place() && scales.signs_right())
    out["gain"] = common->factor;
  if (const auto& layout = scales.layout) {
    out["layout"] = {
        {"transposed", nullptr}, {"mirrored_x", layout->mirrored_x}, {"mirrored_y", layout->mirrored_y}};
    if (layout->transposed) out["layout"]["transposed"] = *layout->transposed;
  }
  return out;
}

}  // namespace slipctl::calibration
