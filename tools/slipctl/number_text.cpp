#include "tools/slipctl/number_text.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace slipctl {
namespace {

std::string printed(const char* format, int decimals, double value) {
  std::array<char, 64> buffer;
  const int size = std::snprintf(buffer.data(), buffer.size(), format, decimals, value);
  return {buffer.data(), static_cast<std::size_t>(size) < buffer.size() ? static_cast<std::size_t>(size)
                                                                        : buffer.size() - 1};
}

}  // namespace

std::string fixed(std::optional<double> value, int decimals, const char* unit) {
  if (!value) return "–";
  const std::string number = printed("%.*f", decimals, *value);
  return *unit == '\0' ? number : number + " " + unit;
}

std::string signed_fixed(double value, int decimals) {
  return printed("%+.*f", decimals, value);
}

std::string with_sigma(std::optional<double> value, std::optional<double> sigma) {
  if (!value) return "–";
  return fixed(value, 2) + (sigma ? " ±" + fixed(sigma, 2) : "");
}

std::string rate(std::optional<double> rate_hz) {
  return rate_hz ? fixed(rate_hz, 0, "Hz") : "– Hz";
}

std::size_t characters(const std::string& utf8) {
  return static_cast<std::size_t>(
      std::count_if(utf8.begin(), utf8.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace slipctl
