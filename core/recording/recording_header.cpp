#include "core/recording/recording_header.hpp"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "core/storage/sealed.hpp"

namespace slipd {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "slipd-recording";
constexpr int kVersion = 2, kFirstVersion = 1;
const SealedKind kSealed{kFormat, kVersion, "is no recording", "is of version "};
constexpr std::size_t kMaxScattered = 16384;
constexpr std::size_t kMaxTextBytes = 4096;
constexpr std::array<std::pair<SensorClass, const char*>, 4> kClasses{
    {{SensorClass::array3, "array3"},
     {SensorClass::wrench, "wrench"},
     {SensorClass::normal, "normal"},
     {SensorClass::displacement, "displacement"}}};

[[noreturn]] void refuse(const std::string& what) {
  throw std::invalid_argument(what);
}

// The value as JSON for an error message, cut to 40 bytes.
std::string shown(const json& value) {
  std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
  if (text.size() > 40) text.replace(37, std::string::npos, "...");
  return text;
}

template <class Predicate>
const json& entry(const json& map, const char* key, const char* expected, Predicate fits) {
  const auto found = map.find(key);
  if (found == map.end()) refuse(std::string("the header has no \"") + key + "\", expected " + expected);
  if (!fits(*found))
    refuse(std::string("the header's \"") + key + "\" is " + shown(*found) + ", expected " + expected);
  return *found;
}

std::string text(const json& map, const char* key) {
  return entry(map, key, "a text", [](const json& v) { return v.is_string(); }).get<std::string>();
}

std::int64_t nanoseconds(const json& map, const char* key) {
  return entry(map, key, "nanoseconds", [](const json& v) { return v.is_number_integer(); })
      .get<std::int64_t>();
}

std::vector<double> coordinates(const json& map, const char* key) {
  const auto fits = [](const json& v) {
    if (!v.is_array() || v.empty() || v.size() > kMaxScattered) return false;
    for (const auto& x : v) {
      if (!x.is_number()) return false;
    }
    return true;
  };
  return entry(map, key, "1 to 16384 coordinates in m", fits).get<std::vector<double>>();
}

json layout_json(const TaxelLayout& layout) {
  if (layout.size() > kRecordingMaxTaxels) refuse("a layout of more than 1048576 taxels cannot be recorded");
  if (const auto& grid = layout.regular())
    return {{"grid", {grid->columns, grid->rows}}, {"pitch_m", grid->pitch_m}};
  if (layout.size() == 1) return {{"side_m", layout.side_m()}};
  if (layout.size() > kMaxScattered)
    refuse("a layout of more than 16384 scattered taxels cannot be recorded");
  return {{"x_m", std::vector<double>(layout.x_m().begin(), layout.x_m().end())},
          {"y_m", std::vector<double>(layout.y_m().begin(), layout.y_m().end())}};
}

TaxelLayout layout_of(const json& map) {
  const auto number = [](const json& v) { return v.is_number(); };
  if (map.contains("grid")) {
    const auto fits = [](const json& v) {
      return v.is_array() && v.size() == 2 && v[0].is_number_unsigned() && v[1].is_number_unsigned() &&
             v[0] <= 4096U && v[1] <= 4096U &&
             v[0].get<std::size_t>() * v[1].get<std::size_t>() <= kRecordingMaxTaxels;
    };
    const auto& grid = entry(map, "grid", "[columns, rows], at most 1048576 taxels in all", fits);
    return TaxelLayout::grid(grid[0], grid[1], entry(map, "pitch_m", "a pitch in m", number).get<double>());
  }
  if (map.contains("side_m"))
    return TaxelLayout::wrench(map.at("side_m").is_number() ? map["side_m"].get<double>() : 0);
  if (map.contains("x_m")) return TaxelLayout::scattered(coordinates(map, "x_m"), coordinates(map, "y_m"));
  refuse("the header's \"layout\" has none of \"grid\", \"x_m\", \"side_m\"");
}

SensorClass class_of(const std::string& name) {
  for (const auto& [value, known] : kClasses) {
    if (name == known) return value;
  }
  refuse("the header's \"class\" is \"" + name.substr(0, 40) +
         "\", expected array3, wrench, normal or displacement");
}

}  // namespace

std::vector<std::uint8_t> encode_header(const RecordingHeader& header) {
  const char* sensor_class = "";
  for (const auto& [value, name] : kClasses) {
    if (value == header.sensor_class) sensor_class = name;
  }
  return seal(kSealed, {{"sensor", header.sensor.substr(0, kMaxTextBytes)},
                        {"class", sensor_class},
                        {"layout", layout_json(header.layout)},
                        {"rate_hz", header.rate_hz},
                        {"simulated", header.simulated},
                        {"start_realtime_ns", header.start_realtime_ns},
                        {"start_monotonic_ns", header.start_monotonic_ns},
                        {"description", header.description.substr(0, kMaxTextBytes)},
                        {"zeroed", header.zeroed}});
}

DecodedHeader decode_header(std::span<const std::uint8_t> item) {
  json map;
  try {
    map = json::from_cbor(item.begin(), item.end(), true, true, json::cbor_tag_handler_t::ignore);
  } catch (const json::exception& e) {
    refuse(std::string("the header is no CBOR that can be understood: ") + e.what());
  }
  if (!map.is_object() || map.value("format", json()) != kFormat) {
    refuse("expected a header map with \"format\" \"slipd-recording\"");
  }
  const json version = map.value("version", json());
  if (version != kVersion && version != kFirstVersion) {
    refuse("the header's \"version\" is " + shown(version) + ", expected 1 or 2: made by a later slipd?");
  }
  if (version == kVersion) {
    try {
      map = unsealed(kSealed, item);
    } catch (const std::exception& e) {  // SealError, json::exception
      refuse(std::string("the header ") + e.what());
    }
    if (!map.is_object()) refuse("the header holds no map");
  }
  const auto boolean = [](const json& v) { return v.is_boolean(); };
  const auto rate = [](const json& v) {
    return v.is_number() && std::isfinite(v.get<double>()) && v.get<double>() >= 0;
  };
  return {.header = {text(map, "sensor"), class_of(text(map, "class")),
                     layout_of(entry(map, "layout", "a map", [](const json& v) { return v.is_object(); })),
                     entry(map, "rate_hz", "a rate in Hz, 0 if unknown", rate).get<double>(),
                     entry(map, "simulated", "true or false", boolean).get<bool>(),
                     nanoseconds(map, "start_realtime_ns"), nanoseconds(map, "start_monotonic_ns"),
                     text(map, "description"),
                     !map.contains("zeroed") || entry(map, "zeroed", "true or false", boolean).get<bool>()},
          .version = version.get<int>()};
}

}  // namespace slipd
