#include "drivers/push/agreement.hpp"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>

namespace slipd::push {
namespace {

using push_layout::Hello;
using push_layout::Unit;
using push_layout::Zero;

// Rates that differ by more contradict each other: the time without frames after which a sensor is stale
// follows from the configured one.
constexpr double kRateTolerance = 0.1;

const char* name_of(Unit unit) noexcept {
  static constexpr const char* kNames[] = {"no unit", "Pa", "N", "counts", "uT", "mm"};
  return kNames[static_cast<std::size_t>(unit)];
}

// Writes the text; false.
[[gnu::format(printf, 2, 3)]] bool refuse(Text& why, const char* format, ...) noexcept {
  std::va_list values;
  va_start(values, format);
  std::vsnprintf(why.data(), why.size(), format, values);
  va_end(values);
  return false;
}

bool read_hello(std::span<const std::uint8_t> message, Hello& hello, Text& why) noexcept {
  if (message.size() == sizeof hello) std::memcpy(&hello, message.data(), sizeof hello);
  if (message.size() != sizeof hello || hello.magic != push_layout::kMagic)
    return refuse(why,
                  "the first message is no hello: it has %zu bytes; a hello has %zu and begins with "
                  "\"slippush\", see docs/push.md",
                  message.size(), sizeof hello);
  const bool reserved = std::ranges::any_of(hello.reserved, [](std::uint8_t byte) { return byte != 0; });
  if (hello.version == push_layout::kVersion && !reserved && hello.zero <= Zero::zero) return true;
  return refuse(why,
                "the hello has version %u or fields that this slipd does not know; it knows version %u: "
                "update slipd, or the program",
                hello.version, push_layout::kVersion);
}

bool check_shape(const Hello& hello, const Options& options, const SensorSetup& sensor, Text& why) noexcept {
  const char* const name = sensor.name.c_str();
  if (hello.taxels != sensor.layout.size())
    return refuse(why,
                  "%s: the program sends %u taxels, the layout in the configuration has %zu: make them agree",
                  name, hello.taxels, sensor.layout.size());
  if (hello.axes != 1 && hello.axes != 3)
    return refuse(why, "%s: the program sends %u values a taxel; send 3 (x, y, z) or 1 (z)", name,
                  hello.axes);
  if (options.axes && hello.axes != *options.axes)
    return refuse(why,
                  "%s: the program sends %u values a taxel, options.axes in the configuration is %u: make "
                  "them agree",
                  name, hello.axes, *options.axes);
  return true;
}

bool is_displacement(const Hello& hello, const Options& options) noexcept {
  return (hello.unit == Unit::unsaid ? options.unit : hello.unit) == Unit::millimetre;
}

bool check_unit(const Hello& hello, const Options& options, const char* name, Text& why) noexcept {
  if (hello.unit > Unit::millimetre)
    return refuse(why, "%s: the program's unit is none that this slipd knows: Pa, N, counts, uT or mm", name);
  if (hello.unit == Unit::unsaid && !options.unit)
    return refuse(why,
                  "%s: neither the program nor options.unit in the configuration says the unit: Pa, N, "
                  "counts, uT or mm",
                  name);
  if (hello.unit != Unit::unsaid && options.unit && hello.unit != *options.unit)
    return refuse(why, "%s: the program sends %s, options.unit in the configuration is %s: make them agree",
                  name, name_of(hello.unit), name_of(*options.unit));
  if (is_displacement(hello, options) && (hello.axes != 3 || options.scale))
    return refuse(why, "%s: frames in mm have 3 values a taxel and no options.scale: docs/push.md", name);
  return true;
}

bool check_rate_and_zero(const Hello& hello, const Options& options, const SensorSetup& sensor,
                         Text& why) noexcept {
  const char* const name = sensor.name.c_str();
  if (!std::isfinite(hello.rate_hz) || hello.rate_hz < 0)
    return refuse(why, "%s: the program's rate is no number of frames a second; 0: as configured", name);
  if (hello.rate_hz > 0 && std::abs(hello.rate_hz - sensor.rate_hz) > kRateTolerance * sensor.rate_hz)
    return refuse(why,
                  "%s: the program sends %g frames a second, rate_hz in the configuration is %g: make them "
                  "agree",
                  name, hello.rate_hz, sensor.rate_hz);
  const bool zeroed = hello.zero == Zero::zero;
  if (hello.zero != Zero::unsaid && options.zeroed && zeroed != *options.zeroed)
    return refuse(why,
                  "%s: the program says that its frames are %s, options.zeroed in the configuration is %s: "
                  "make them agree",
                  name, zeroed ? "zeroed" : "not zeroed", *options.zeroed ? "true" : "false");
  return true;
}

Agreement agreement_on(Unit unit, std::uint8_t axes, bool zeroed, const Options& options,
                       const SensorSetup& sensor) noexcept {
  const bool displacement = unit == Unit::millimetre;
  const bool calibrated = unit == Unit::pascal || unit == Unit::newton || displacement || options.scale;
  std::array<float, 3> scale = options.scale.value_or(std::array<float, 3>{1, 1, 1});
  if (unit == Unit::newton)
    for (float& each : scale) each /= static_cast<float>(sensor.layout.area_m2());
  return {.taxels = sensor.layout.size(),
          .axes = axes,
          .scale = scale,
          .zeroed = (zeroed && calibrated) || displacement,
          .calibrated = calibrated,
          .displacement = displacement};
}

}  // namespace

Agreement agreement_without_hello(const Options& options, const SensorSetup& sensor) noexcept {
  return agreement_on(options.unit.value_or(Unit::pascal), options.axes.value_or(3),
                      options.zeroed.value_or(false), options, sensor);
}

bool agree(std::span<const std::uint8_t> message, const Options& options, const SensorSetup& sensor,
           Agreement& agreed, Text& why) noexcept {
  Hello hello;
  if (!read_hello(message, hello, why) || !check_shape(hello, options, sensor, why) ||
      !check_unit(hello, options, sensor.name.c_str(), why) ||
      !check_rate_and_zero(hello, options, sensor, why))
    return false;
  const Unit unit = hello.unit == Unit::unsaid ? *options.unit : hello.unit;
  const bool zeroed = hello.zero == Zero::unsaid ? options.zeroed.value_or(false) : hello.zero == Zero::zero;
  agreed = agreement_on(unit, hello.axes, zeroed, options, sensor);
  return true;
}

}  // namespace slipd::push
