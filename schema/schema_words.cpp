#include "schema/schema_words.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "schema/schema.hpp"

namespace slipd {
namespace {

using nlohmann::json;

std::string dumped(const json& v) {
  return v.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string number_text(const json& v) {
  const auto d = v.get<double>();
  constexpr double kExact = 1e15;  // integers below are exact in a double, and readable
  return std::abs(d) < kExact && d == std::floor(d) ? std::to_string(static_cast<long long>(d)) : dumped(v);
}

// " from 1 to 5", " above 0 up to 10", " of at least 3", …. `min` and `max` are keywords, either may be
// absent from the schema.
std::string range_text(const json& schema, const char* min, const char* max) {
  std::string text;
  const bool above = schema.contains("exclusiveMinimum"), from = schema.contains(min);
  const bool below = schema.contains("exclusiveMaximum"), to = schema.contains(max);
  if (above) text += " above " + number_text(schema["exclusiveMinimum"]);
  if (from) text += (to ? " from " : " of at least ") + number_text(schema[min]);
  if (to) text += (from ? " to " : " up to ") + number_text(schema[max]);
  if (below) text += (above || from ? " and below " : " below ") + number_text(schema["exclusiveMaximum"]);
  return text;
}

std::string counted(const json& schema, const char* min, const char* max, const std::string& things) {
  if (schema.contains(min) && schema.contains(max) && schema[min] == schema[max]) {
    return " of " + number_text(schema[min]) + " " + things;
  }
  std::string range = range_text(schema, min, max);
  if (range.empty()) return "";
  if (range.starts_with(" from ")) range = " of" + range.substr(5);
  return range + " " + things;
}

std::string wanted_of_type(const std::string& type, const json& schema) {
  if (type == "number" || type == "integer") {
    const std::string range = range_text(schema, "minimum", "maximum");
    const std::string unit = schema.value("unit", "");
    return (type == "number" ? "a number" : "an integer") + range +
           (unit.empty() ? "" : (range.empty() ? " in " : " ") + unit);
  }
  if (type == "string") {
    return "a string" + counted(schema, "minLength", "maxLength", "characters") +
           (schema.contains("pattern") ? " matching " + schema["pattern"].get<std::string>() : "");
  }
  if (type == "boolean") return "true or false";
  if (type == "array") {
    const std::string unit = schema.value("unit", "");
    std::string text = "a list" + counted(schema, "minItems", "maxItems", "items");
    if (schema.contains("items") && !schema["items"].contains("$ref"))
      text += ", each " + wanted(schema["items"]);
    return unit.empty() ? text : text + " " + unit;
  }
  return type == "object" ? "an object" : type;
}

// The Damerau-Levenshtein distance (a transposition counts once), ignoring case.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  const auto same = [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
  };
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), now(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, last[j - 1] + (same(a[i - 1], b[j - 1]) ? 0 : 1)});
      if (i > 1 && j > 1 && same(a[i - 1], b[j - 2]) && same(a[i - 2], b[j - 1])) {
        now[j] = std::min(now[j], before[j - 2] + 1);
      }
    }
    before.swap(last);
    last.swap(now);
  }
  return last[b.size()];
}

}  // namespace

std::string joined(const std::vector<std::string>& parts, const char* between) {
  std::string text;
  for (const auto& part : parts) text += (text.empty() ? "" : between) + part;
  return text;
}

std::string kind_of(const json& value) {
  if (value.is_number_float()) return "a fraction";
  if (value.is_number()) return "an integer";
  if (value.is_string()) return "a string";
  if (value.is_boolean()) return "a boolean";
  if (value.is_array()) return "a list";
  return value.is_object() ? "an object" : "null";
}

std::string wanted(const json& schema) {
  if (schema.contains("form")) return schema["form"];
  for (const char* choice : {"anyOf", "oneOf"}) {
    if (!schema.contains(choice)) continue;
    std::vector<std::string> parts;
    for (const auto& one : schema[choice]) parts.push_back(wanted(one));
    return joined(parts, " or ");
  }
  if (schema.contains("enum")) {
    std::vector<std::string> parts;
    for (const auto& one : schema["enum"]) parts.push_back(shown(one));
    return (parts.size() > 1 ? "one of " : "") + joined(parts, ", ");
  }
  if (!schema.contains("type")) return "something else";
  if (schema["type"].is_string()) return wanted_of_type(schema["type"], schema);
  std::vector<std::string> parts;
  for (const auto& type : schema["type"]) parts.push_back(wanted_of_type(type, schema));
  return joined(parts, " or ");
}

std::string shown(const json& value) {
  const auto nested = [](const json& v) { return v.is_structured() && !v.empty(); };
  if (value.is_object() && !value.empty()) return "{…}";
  if (value.is_array() && (value.size() > 8 || std::any_of(value.begin(), value.end(), nested))) return "[…]";
  if (value.is_number_float() && !std::isfinite(value.get<double>())) return "not a finite number";
  std::string text = dumped(value);
  constexpr std::size_t kLongest = 80;
  if (text.size() <= kLongest) return text;
  std::size_t end = kLongest;
  while ((static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;  // not within a character
  return text.substr(0, end) + "…";
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates) {
  constexpr std::size_t kLongest = 64;
  if (word.size() > kLongest) return "";
  const std::string* best = nullptr;
  std::size_t least = std::min(word.size(), 1 + std::max<std::size_t>(1, word.size() / 3));
  for (const auto& candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance >= least) continue;
    least = distance;
    best = &candidate;
  }
  return best == nullptr ? "" : "; did you mean " + dumped(*best) + "?";
}

}  // namespace slipd
