#include "tests/config/violations.hpp"

#include <algorithm>
#include <functional>

namespace slipd::test {
namespace {

using nlohmann::json;
using Pointer = json::json_pointer;

class Surveyor {
 public:
  explicit Surveyor(const json& root) : root_(root) { list_keys("", root); }

  void visit(const json& raw, const json& value, const Pointer& at, const std::string& path) {
    const json schema = resolved(raw);
    wrong_types(schema, at);
    for (const json& choice : choices(schema)) wrong_values(choice, value, at);
    if (schema.contains("properties") && value.is_object()) {
      for (const auto& [key, property] : schema["properties"].items()) {
        if (!value.contains(key)) continue;
        found.keys.push_back({at, key});
        const std::string name = named(raw, path) + "." + key;
        found.seen.insert(name);
        visit(property, value[key], at / key, name);
      }
    }
    if (schema.contains("items") && value.is_array()) {
      for (std::size_t i = 0; i < value.size(); ++i) visit(schema["items"], value[i], at / i, path);
    }
  }

  Survey found;

 private:
  static std::string named(const json& raw, const std::string& path) {
    return raw.contains("$ref") ? raw["$ref"].get<std::string>().substr(8) : path;
  }

  void list_keys(const std::string& path, const json& schema) {
    if (schema.contains("properties")) {
      for (const auto& [key, property] : schema["properties"].items()) {
        std::string name = path;
        name.append(".").append(key);
        list_keys(name, property);
        found.all.insert(std::move(name));
      }
    }
    if (!schema.contains("$defs")) return;
    for (const auto& [name, def] : schema["$defs"].items()) list_keys(name, def);
  }

  json resolved(const json& schema) const {
    if (!schema.contains("$ref")) return schema;
    json merged = root_["$defs"][schema["$ref"].get<std::string>().substr(8)];
    merged.update(schema);
    return merged;
  }

  static std::vector<json> choices(const json& schema) {
    if (!schema.contains("anyOf")) return {schema};
    return schema["anyOf"].get<std::vector<json>>();
  }

  static std::set<std::string> types(const json& schema) {
    std::set<std::string> out;
    for (const json& choice : choices(schema)) {
      if (choice.contains("type")) out.insert(choice["type"].get<std::string>());
      if (choice.contains("enum")) out.insert("string");
    }
    if (out.contains("number")) out.insert("integer");
    return out;
  }

  void add(const Pointer& at, json bad) { found.violations.push_back({at, std::move(bad)}); }

  void wrong_types(const json& schema, const Pointer& at) {
    const std::vector<std::pair<std::string, json>> samples{{"null", nullptr},
                                                            {"boolean", true},
                                                            {"integer", 1},
                                                            {"number", 1.5},
                                                            {"string", "of no form at all\n"},
                                                            {"array", json::array()},
                                                            {"object", json::object()}};
    const auto allowed = types(schema);
    for (const auto& [type, sample] : samples) {
      if (!allowed.contains(type)) add(at, sample);
    }
  }

  void wrong_values(const json& schema, const json& value, const Pointer& at) {
    const auto has = [&](const char* key) { return schema.contains(key); };
    if (has("minimum")) add(at, schema["minimum"].get<double>() - 1), add(at, -1e300);
    if (has("maximum")) add(at, schema["maximum"].get<double>() + 1), add(at, 1e300);
    if (has("exclusiveMinimum")) add(at, schema["exclusiveMinimum"]);
    if (has("exclusiveMaximum")) add(at, schema["exclusiveMaximum"]);
    if (has("enum")) add(at, "no such choice");
    if (has("pattern")) add(at, "/ of no form \n"), add(at, ""), add(at, std::string(5000, 'x'));
    if (has("minLength")) add(at, "");
    if (has("maxLength")) add(at, std::string(schema["maxLength"].get<std::size_t>() + 1, 'x'));
    if (!value.is_array() || value.empty()) return;
    if (has("minItems")) add(at, json::array());
    if (has("maxItems")) add(at, json::array_t(schema["maxItems"].get<std::size_t>() + 1, value[0]));
    if (has("uniqueItems")) add(at, {value[0], value[0]});
  }

  const json& root_;
};

}  // namespace

Survey survey(const json& schema, const json& document) {
  Surveyor surveyor(schema);
  surveyor.visit(schema, document, Pointer(), "");
  return std::move(surveyor.found);
}

}  // namespace slipd::test
