// Ways to break a document, derived from its schema: so that no key can be added without being tried.
#pragma once

#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

namespace slipd::test {

struct Violation {
  nlohmann::json::json_pointer at;
  nlohmann::json bad;  // to be put there
};

struct Key {
  nlohmann::json::json_pointer parent;  // the object in the document that has it
  std::string name;
};

struct Survey {
  std::vector<Violation> violations;  // out of range, wrong type, wrong form, wrong length
  std::vector<Key> keys;              // every key of the document that the schema knows
  std::set<std::string> seen;         // keys of the schema that the document has, as `definition.key`
  std::set<std::string> all;          // keys that the schema has
};

// Walks `schema` and the valid `document` side by side.
Survey survey(const nlohmann::json& schema, const nlohmann::json& document);

}  // namespace slipd::test
