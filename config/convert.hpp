// Checked JSON → Settings, and the checks that no schema can say: convert.cpp, and convert_sensors.cpp for
// the sensors. Inside of settings.cpp, apart for size.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "config/settings.hpp"
#include "schema/schema.hpp"

namespace slipd {

// Whether any of `problems` lies at `pointer`, below it, or above it (what lies in a list that is too long
// was not looked at).
bool is_touched(const std::vector<Problem>& problems, const std::string& pointer);

// Divided, not multiplied by 0.001: so 2 mm are the double nearest to 0.002.
inline double metres_of_mm(const nlohmann::json& mm) {
  return mm.get<double>() / 1e3;
}
inline double pascals_of_mpa(const nlohmann::json& mpa) {
  return mpa.get<double>() * 1e6;
}

// Each element of the list `at` needs a name of its own.
void check_names_differ(const nlohmann::json& list, const std::string& at, std::vector<Problem>& problems);

// `root` is an object that check() has seen, with `problems` found; sections among which there is one are
// left out of the result, the others are converted and checked further, so that all problems come out at
// once.
Settings convert(const nlohmann::json& root, std::vector<Problem>& problems);
std::vector<SensorSettings> convert_sensors(const nlohmann::json& list, std::vector<Problem>& problems);

}  // namespace slipd
