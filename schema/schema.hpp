// A walker of a subset of JSON Schema that checks, fills in defaults, and tells people what is wrong. Set-up
// only; used for the configuration, drivers' options and device profiles.
//
// valijson was considered: it fills in no defaults, and its messages name the schema's rule but neither the
// value, the range, the unit nor the key that was meant, which is most of what this file does.
//
// The subset: type (one or a list), enum, minimum, maximum, exclusiveMinimum, exclusiveMaximum, minLength,
// maxLength, pattern, properties, required, additionalProperties (boolean or schema), items, minItems,
// maxItems, uniqueItems, anyOf, oneOf, $ref ("#" or "#/$defs/NAME"), default, and the annotations title,
// description, examples, $comment, $schema, $id, $defs. Two of our own: "unit" stands behind the range in
// messages; "form" says in words what a pattern asks for. Anything else in a schema is an error in that
// schema. A whole number such as 5.0 is an integer and is made one.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace slipd {

struct Problem {
  std::string pointer;  // JSON pointer to the value, "" for the whole
  std::string value;    // as JSON, shortened; empty for a value that is missing
  std::string what;     // what is wrong, the range and unit

  std::string in(const std::string& file) const;  // `FILE: /pointer = value: what`
  bool operator==(const Problem&) const = default;
};

// The schema itself is at fault: a keyword outside the subset, a $ref to nowhere, a pattern that is no
// pattern.
class SchemaError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// check() stops here: nobody reads more, and a list of a million strings has a million problems.
inline constexpr std::size_t kMostProblems = 500;

// All problems of `value` (the first kMostProblems), which lies at the JSON pointer `at`; none: it fits, and
// every absent key that has a default holds it now. A default that does not fit its own schema is reported
// like a user's value. Throws SchemaError only.
std::vector<Problem> check(const nlohmann::json& schema, nlohmann::json& value, const std::string& at = "");

// A problem that no schema can say, in the same shape.
Problem problem_of(std::string pointer, const nlohmann::json& value, std::string what);

// `at`/`key` as a JSON pointer, on one line whatever the key holds.
std::string pointer_to(const std::string& at, std::string_view key);
std::string pointer_to(const std::string& at, std::size_t index);

// `; did you mean "x"?` for the candidate that is only a few slips away from `word`, or nothing.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace slipd
