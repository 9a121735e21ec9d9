// Values of a JSON object that may lack them. A missing or null key, or one of another type (an older or
// newer slipd), gives an absent value and no error. Any one thread.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "clients/c/connection.hpp"

namespace slipd::client {

// null if there is none.
inline const Json& member(const Json& object, const char* key) {
  static const Json nothing;
  if (!object.is_object()) return nothing;
  const auto found = object.find(key);
  return found == object.end() ? nothing : *found;
}

inline std::string text(const Json& object, const char* key, const char* otherwise = "") {
  const Json& value = member(object, key);
  return value.is_string() ? value.get<std::string>() : otherwise;
}

inline std::optional<double> number(const Json& object, const char* key) {
  const Json& value = member(object, key);
  return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

// 0 if there is none, or a negative one.
inline std::uint64_t count(const Json& object, const char* key) {
  const Json& value = member(object, key);
  return value.is_number_integer() && value >= 0 ? value.get<std::uint64_t>() : 0;
}

// 0 if there is none.
inline std::int64_t integer(const Json& object, const char* key) {
  const Json& value = member(object, key);
  return value.is_number_integer() ? value.get<std::int64_t>() : 0;
}

inline bool flag(const Json& object, const char* key) {
  return member(object, key) == true;
}

}  // namespace slipd::client
