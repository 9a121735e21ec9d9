#include "schema/schema.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <utility>

#include "embedded/slipd_meta_schema.hpp"
#include "schema/json_text.hpp"
#include "schema/schema_words.hpp"

namespace slipd {
namespace {

using nlohmann::json;

constexpr int kDeepest = 200;                         // recursion, with $ref and anyOf
constexpr double kLargestExact = 9007199254740992.0;  // 2^53: a double cannot represent every integer beyond

bool has_type(const json& value, const std::string& type) {
  if (type == "number") return value.is_number();
  if (type == "integer") {
    if (!value.is_number_float()) return value.is_number();
    const auto d = value.get<double>();
    return d == std::floor(d) && std::abs(d) <= kLargestExact;
  }
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "array") return value.is_array();
  return type == "object" ? value.is_object() : value.is_null();
}

bool fits_type(const json& schema, const json& value) {
  if (!schema.contains("type")) return true;
  const json& type = schema["type"];
  if (type.is_string()) return has_type(value, type);
  return std::any_of(type.begin(), type.end(), [&](const json& one) { return has_type(value, one); });
}

std::size_t characters(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

class Walker {
 public:
  explicit Walker(const json& root) : root_(root) {}

  // Appends the problems of `value` and fills in its defaults.
  void walk(const json& schema, json& value, const std::string& at, int depth,
            std::vector<Problem>& problems) const {
    if (problems.size() >= kMostProblems) return;
    if (depth > kDeepest) return problems.push_back(problem_of(at, value, "is nested too deeply"));
    if (schema.contains("$ref")) return walk(resolved(schema), value, at, depth + 1, problems);
    const auto wrong = [&](const std::string& what) {
      problems.push_back(problem_of(at, value, what + "; expected " + wanted(schema)));
    };
    if (!fits_type(schema, value)) return wrong("is " + kind_of(value));
    for (const char* choice : {"anyOf", "oneOf"}) {
      if (schema.contains(choice)) choose(schema, choice, value, at, depth, problems);
    }
    if (schema.contains("enum")) {
      const json& allowed = schema["enum"];
      if (std::find(allowed.begin(), allowed.end(), value) == allowed.end()) wrong("is none of those known");
    }
    if (value.is_number()) walk_number(schema, value, wrong);
    if (value.is_string()) walk_string(schema, value.get_ref<const std::string&>(), wrong);
    if (value.is_array()) walk_array(schema, value, at, depth, problems, wrong);
    if (value.is_object()) walk_object(schema, value, at, depth, problems);
  }

 private:
  // The schema that a $ref points to, merged with the keywords beside the $ref; a schema without $ref itself.
  // `schema` must outlive the walker: merged schemas are cached by its address, because merging for every
  // item of a list would take most of the time.
  const json& resolved(const json& schema) const {
    if (!schema.contains("$ref")) return schema;
    if (const auto known = merged_.find(&schema); known != merged_.end()) return known->second;
    constexpr std::string_view kDefs = "#/$defs/";
    const std::string& ref = schema["$ref"].get_ref<const std::string&>();
    const json* target = nullptr;
    if (ref == "#") target = &root_;
    if (ref.starts_with(kDefs) && root_.contains("$defs")) {
      const auto found = root_["$defs"].find(ref.substr(kDefs.size()));
      if (found != root_["$defs"].end()) target = &*found;
    }
    if (target == nullptr) throw SchemaError("the schema refers to " + ref + ", which it does not have");
    json merged = *target;
    for (const auto& [key, beside] : schema.items()) {
      if (key != "$ref") merged[key] = beside;
    }
    return merged_.emplace(&schema, std::move(merged)).first->second;
  }

  // anyOf accepts the first that fits; oneOf needs exactly one that fits.
  void choose(const json& schema, const std::string& keyword, json& value, const std::string& at, int depth,
              std::vector<Problem>& problems) const {
    std::vector<json> fitting;
    std::vector<std::vector<Problem>> of_same_type;
    for (const auto& raw : schema[keyword]) {
      const json& choice = resolved(raw);
      json copy = value;
      std::vector<Problem> found;
      walk(choice, copy, at, depth + 1, found);
      if (found.empty()) {
        fitting.push_back(std::move(copy));
        if (keyword == "anyOf") break;
      } else if (fits_type(choice, value)) {
        of_same_type.push_back(std::move(found));
      }
    }
    if (fitting.size() == 1) {
      value = std::move(fitting.front());
      return;
    }
    json described = schema;
    described[keyword] = json::array();
    for (const auto& raw : schema[keyword]) described[keyword].push_back(resolved(raw));
    const std::string expected = "; expected " + wanted(described);
    if (fitting.size() > 1) {
      problems.push_back(problem_of(at, value, "fits more than one of these" + expected));
    } else if (of_same_type.size() != 1) {
      problems.push_back(problem_of(at, value, "is " + kind_of(value) + expected));
    } else {  // the only alternative of the value's type: its own problems are the cause
      for (auto& problem : of_same_type.front()) {
        const bool itself = problem.pointer == at;
        if (itself) problem.what = problem.what.substr(0, problem.what.find("; expected ")) + expected;
        problems.push_back(std::move(problem));
      }
    }
  }

  template <typename Wrong>
  static void walk_number(const json& schema, json& value, const Wrong& wrong) {
    const auto d = value.get<double>();
    const auto bound = [&](const char* key) { return schema[key].template get<double>(); };
    if (!std::isfinite(d)) return wrong("is no finite number");
    if ((schema.contains("minimum") && d < bound("minimum")) ||
        (schema.contains("exclusiveMinimum") && d <= bound("exclusiveMinimum"))) {
      return wrong("is too small");
    }
    if ((schema.contains("maximum") && d > bound("maximum")) ||
        (schema.contains("exclusiveMaximum") && d >= bound("exclusiveMaximum"))) {
      return wrong("is too large");
    }
    if (value.is_number_float() && schema.contains("type") && schema["type"] == "integer") {
      value = static_cast<std::int64_t>(d);
    }
  }

  template <typename Wrong>
  void walk_string(const json& schema, const std::string& text, const Wrong& wrong) const {
    const std::size_t length = characters(text);
    if (schema.contains("minLength") && length < schema["minLength"].get<std::size_t>())
      return wrong("is too short");
    if (schema.contains("maxLength") && length > schema["maxLength"].get<std::size_t>())
      return wrong("is too long");
    if (!schema.contains("pattern")) return;
    constexpr std::size_t kLongest = 4096;  // std::regex recurses over the text
    if (text.size() > kLongest) return wrong("is too long");
    if (!std::regex_search(text, pattern(schema["pattern"]))) wrong("has another form");
  }

  const std::regex& pattern(const std::string& text) const {
    if (const auto known = patterns_.find(text); known != patterns_.end()) return known->second;
    try {
      return patterns_.emplace(text, text).first->second;
    } catch (const std::regex_error& e) {
      throw SchemaError("the schema's pattern " + text + " is no regular expression: " + e.what());
    }
  }

  template <typename Wrong>
  void walk_array(const json& schema, json& value, const std::string& at, int depth,
                  std::vector<Problem>& problems, const Wrong& wrong) const {
    if (schema.contains("minItems") && value.size() < schema["minItems"].get<std::size_t>())
      wrong("has too few items");
    if (schema.contains("maxItems") && value.size() > schema["maxItems"].get<std::size_t>())
      return wrong("has too many items");
    for (std::size_t i = 0; schema.contains("items") && i < value.size(); ++i) {
      walk(schema["items"], value[i], pointer_to(at, i), depth + 1, problems);
    }
    if (schema.value("uniqueItems", false)) {
      for (std::size_t i = 1; i < value.size(); ++i) {
        const auto here = value.begin() + static_cast<std::ptrdiff_t>(i);
        if (std::find(value.begin(), here, *here) == here) continue;
        problems.push_back(problem_of(pointer_to(at, i), *here, "is in the list twice; once is enough"));
      }
    }
  }

  void walk_object(const json& schema, json& value, const std::string& at, int depth,
                   std::vector<Problem>& problems) const {
    static const json kNone = json::object();
    const json& properties = schema.contains("properties") ? schema["properties"] : kNone;
    const json& others = schema.contains("additionalProperties") ? schema["additionalProperties"] : kNone;
    for (const auto& [key, property] : properties.items()) {
      const json& described = resolved(property);
      if (!value.contains(key) && described.contains("default")) value[key] = described["default"];
      if (value.contains(key)) walk(described, value[key], pointer_to(at, key), depth + 1, problems);
    }
    for (const auto& key : schema.contains("required") ? schema["required"] : json::array()) {
      if (value.contains(key)) continue;
      const json& property = properties.contains(key) ? properties[key.get<std::string>()] : kNone;
      const json& described = resolved(property);
      problems.push_back({pointer_to(at, key.get_ref<const std::string&>()), "",
                          "is missing; expected " + wanted(described)});
    }
    for (auto& [key, member] : value.items()) {
      if (properties.contains(key) || problems.size() >= kMostProblems) continue;
      if (others.is_object()) {
        walk(others, member, pointer_to(at, key), depth + 1, problems);
      } else if (!others.get<bool>()) {
        problems.push_back(
            problem_of(pointer_to(at, key), member, "is an unknown key" + hint(key, properties)));
      }
    }
  }

  static std::string hint(const std::string& key, const json& properties) {
    std::vector<std::string> known;
    for (const auto& [name, property] : properties.items()) known.push_back(name);
    std::string text = did_you_mean(key, known);
    if (!text.empty()) return text;
    for (const auto& one : known) text += (text.empty() ? "; known here: " : ", ") + one;
    return text.empty() ? "; none is known here" : text;
  }

  const json& root_;
  mutable std::map<const json*, json> merged_;
  mutable std::map<std::string, std::regex> patterns_;
};

}  // namespace

std::vector<Problem> check(const json& schema, json& value, const std::string& at) {
  // The schema of schemas. A schema that passed it needs no further checks in the walker.
  static const json kMeta = json::parse(slipd_meta_schema);
  json copy = schema;
  std::vector<Problem> problems;
  Walker(kMeta).walk(kMeta, copy, "", 0, problems);
  if (!problems.empty()) throw SchemaError(problems.front().in("schema"));
  Walker(schema).walk(schema, value, at, 0, problems);
  return problems;
}

Problem problem_of(std::string pointer, const json& value, std::string what) {
  return {std::move(pointer), shown(value), std::move(what)};
}

Problem problem_at(const std::string& pointer, const json& document, std::string what) {
  return problem_of(pointer, document.at(json::json_pointer(pointer)), std::move(what));
}

std::string Problem::in(const std::string& file) const {
  return plain(file + ": " + (pointer.empty() ? "/" : pointer) + (value.empty() ? "" : " = " + value) + ": " +
               what);
}

std::string pointer_to(const std::string& at, std::string_view key) {
  std::string token;
  for (const char c : key) token += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  const std::string quoted = json(token).dump(-1, ' ', false, json::error_handler_t::replace);
  return at + "/" + quoted.substr(1, quoted.size() - 2);
}

std::string pointer_to(const std::string& at, std::size_t index) {
  return at + "/" + std::to_string(index);
}

}  // namespace slipd
