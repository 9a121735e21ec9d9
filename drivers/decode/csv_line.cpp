#include "drivers/decode/csv_line.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>

namespace slipd::decode {
namespace {

static_assert(std::endian::native == std::endian::little, "doubles are copied as they are");

bool is_blank(char c) noexcept {
  return c == ' ' || c == '\t' || c == '\r';
}

bool is_separator(char c) noexcept {
  return c == ',' || c == ';';
}

}  // namespace

bool numbers_of_line(std::span<const std::uint8_t> line, std::span<std::uint8_t> to) noexcept {
  const char* at = reinterpret_cast<const char*>(line.data());
  const char* const end = at + line.size();
  for (std::size_t filled = 0; filled < to.size(); filled += sizeof(double)) {
    const char* const behind = at;
    at = std::find_if_not(at, end, is_blank);
    if (filled > 0 && at != end && is_separator(*at)) at = std::find_if_not(at + 1, end, is_blank);
    if (filled > 0 && at == behind) return false;
    if (at != end && *at == '+') ++at;
    double value = 0;
    const auto [rest, error] = std::from_chars(at, end, value);
    if (error != std::errc()) return false;
    at = rest;
    std::memcpy(to.data() + filled, &value, sizeof value);
  }
  return std::all_of(at, end, is_blank);
}

}  // namespace slipd::decode
