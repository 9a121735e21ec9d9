#include "bridges/feed/document.hpp"

#include <yaml-cpp/yaml.h>

#include <nlohmann/json.hpp>
#include <string>

namespace slipd::feed {
namespace {

using nlohmann::json;

// Of a head. Fewer: heads of many sensors are refused. More: aliases of aliases take memory and time.
constexpr int kMostYamlValues = 4096;

// Right of a JSON text; of what is none, anything.
bool nested_too_deeply(std::span<const std::uint8_t> text) {
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::uint8_t c = text[i];
    if (c == '"') quoted = !quoted;
    if (quoted && c == '\\') ++i;
    if (quoted) continue;
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (depth > kDeepestDocument) return true;
  }
  return false;
}

// Scalars that look like numbers are numbers. False: too many values, or nested too deeply.
bool convert(const YAML::Node& node, json& out, int& left, int depth) {
  if (--left < 0 || depth > kDeepestDocument) return false;
  if (node.IsSequence()) {
    out = json::array();
    for (const YAML::Node& element : node)
      if (!convert(element, out.emplace_back(), left, depth + 1)) return false;
  } else if (node.IsMap()) {
    out = json::object();
    for (const auto& entry : node)
      if (!entry.first.IsScalar() || !convert(entry.second, out[entry.first.Scalar()], left, depth + 1))
        return false;
  } else if (node.IsScalar()) {
    std::int64_t whole = 0;
    double real = 0;
    if (YAML::convert<std::int64_t>::decode(node, whole))
      out = whole;
    else if (YAML::convert<double>::decode(node, real))
      out = real;
    else
      out = node.Scalar();
  }
  return true;
}

}  // namespace

bool parse_json(std::span<const std::uint8_t> text, json& out) {
  if (nested_too_deeply(text)) return false;
  out = json::parse(text.begin(), text.end(), nullptr, false);
  return !out.is_discarded();
}

bool parse_yaml(std::span<const std::uint8_t> text, json& out) {
  int left = kMostYamlValues;
  try {
    return convert(YAML::Load(std::string(text.begin(), text.end())), out, left, 0);
  } catch (const YAML::Exception&) {
    return false;
  }
}

}  // namespace slipd::feed
