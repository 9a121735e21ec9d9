// Formats numbers for people. An unknown number is a dash, never a zero.
#pragma once

#include <optional>
#include <string>

namespace slipctl {

std::string fixed(std::optional<double> value, int decimals, const char* unit = "");  // "2.10 N", "–"
std::string signed_fixed(double value, int decimals);                                 // "+0.5"
std::string with_sigma(std::optional<double> value, std::optional<double> sigma);     // "0.62 ±0.01", "–"
std::string rate(std::optional<double> rate_hz);                                      // "1000 Hz"

// How many characters these bytes of UTF-8 are.
std::size_t characters(const std::string& utf8);

}  // namespace slipctl
