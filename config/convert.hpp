// Converts checked JSON to Settings and makes the checks that a schema cannot express: convert.cpp, and
// convert_sensors.cpp for the sensors. Private to settings.cpp. Called from one thread: io.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "config/settings.hpp"
#include "schema/schema.hpp"

namespace slipd {

// Whether one of `problems` is at `pointer`, below it or above it (the items of a list that is too long were
// not checked).
bool has_problem_at(const std::vector<Problem>& problems, const std::string& pointer);

// Whether one of `problems` is of the value at `pointer` itself.
bool has_problem_exactly_at(const std::vector<Problem>& problems, const std::string& pointer);

// Division, not multiplication by 0.001: so 2 mm become the double nearest to 0.002.
inline double metres_of_mm(const nlohmann::json& mm) {
  return mm.get<double>() / 1e3;
}
inline double pascals_of_mpa(const nlohmann::json& mpa) {
  return mpa.get<double>() * 1e6;
}

// Adds a problem for each item of `list`, at the pointer `at`, whose name another item has.
void check_names_differ(const nlohmann::json& list, const std::string& at, std::vector<Problem>& problems);

// Converts `root`, an object that check() has seen and in which it found `problems`. Sections with a problem
// are skipped; the others are converted and checked further, so that all problems are reported at once.
// Appends to `problems`. `written`: the same before check() filled in defaults.
Settings convert(const nlohmann::json& root, const nlohmann::json& written, std::vector<Problem>& problems);
// The same for the list of sensors.
std::vector<SensorSettings> convert_sensors(const nlohmann::json& list, const nlohmann::json& written,
                                            std::vector<Problem>& problems);

}  // namespace slipd
