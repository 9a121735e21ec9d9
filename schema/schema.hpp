// Checks a value against a JSON Schema, fills in defaults, and describes each problem for people. Used for
// the configuration, drivers' options and device profiles. Called from any thread that may allocate: io,
// set-up, a tool.
//
// Decision: valijson does not fill in defaults, and its messages name the violated keyword but not the value,
// the range, the unit or a similar key.
//
// The subset of JSON Schema: type (one or a list), enum, minimum, maximum, exclusiveMinimum,
// exclusiveMaximum, minLength, maxLength, pattern, properties, required, additionalProperties (boolean or
// schema), items, minItems, maxItems, uniqueItems, anyOf, oneOf, $ref ("#" or "#/$defs/NAME"), default, and
// the annotations title, description, examples, $comment, $schema, $id, $defs. Two additions: "unit" is shown
// behind the range in messages; "form" describes a pattern in words. Any other keyword is an error of the
// schema. A whole number such as 5.0 is an integer and is converted to one.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace slipd {

// What is wrong with one value.
struct Problem {
  // JSON pointer to the value; empty: the whole document.
  std::string pointer;
  // The value as JSON, shortened; empty: the value is missing.
  std::string value;
  // What is wrong, and what is expected with range and unit.
  std::string what;

  // `FILE: /pointer = value: what`
  std::string in(const std::string& file) const;
  bool operator==(const Problem&) const = default;
};

// The schema itself is wrong: a keyword outside the subset, a $ref without target, an invalid pattern.
class SchemaError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// check() stops after this many problems: a list of a million strings could have a million.
inline constexpr std::size_t kMostProblems = 500;

// The problems of `value`, which is at the JSON pointer `at`; at most kMostProblems. None: the value fits,
// and every absent key with a default has it now. A default that does not fit its own schema is reported like
// a user's value. Throws SchemaError only.
std::vector<Problem> check(const nlohmann::json& schema, nlohmann::json& value, const std::string& at = "");

// A problem found by other means than a schema, in the same form.
Problem problem_of(std::string pointer, const nlohmann::json& value, std::string what);

// The same of the value at this pointer of a document, which has one there.
Problem problem_at(const std::string& pointer, const nlohmann::json& document, std::string what);

// The JSON pointer `at`/`key`, with control characters escaped.
std::string pointer_to(const std::string& at, std::string_view key);
std::string pointer_to(const std::string& at, std::size_t index);

// `; did you mean "x"?` for the candidate with the smallest edit distance to `word`; empty if none is near.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace slipd
