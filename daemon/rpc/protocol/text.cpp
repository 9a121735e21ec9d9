#include "daemon/rpc/protocol/text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

namespace slipd {
namespace {

// Longest shortest double, and longest 64 bit integer.
constexpr std::size_t kLongest = 32;

}  // namespace

void append_number(std::string& out, std::optional<double> value) {
  if (!value || !std::isfinite(*value)) {
    out += "null";
    return;
  }
  std::array<char, kLongest> digits;
  const char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), *value).ptr;
  const std::string_view text(digits.data(), static_cast<std::size_t>(end - digits.data()));
  out += text;
  if (text.find_first_of(".e") == text.npos) out += ".0";
}

void append_integer(std::string& out, std::optional<std::int64_t> value) {
  if (!value) {
    out += "null";
    return;
  }
  std::array<char, kLongest> digits;
  const char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), *value).ptr;
  out.append(digits.data(), static_cast<std::size_t>(end - digits.data()));
}

void append_ms(std::string& out, std::int64_t time_ns) {
  constexpr std::int64_t kPerMs = 1'000'000;
  append_integer(out, time_ns / kPerMs);
  std::array<char, 7> digits{'.'};
  std::int64_t rest = time_ns % kPerMs;
  for (std::size_t i = digits.size() - 1; i > 0; --i, rest /= 10)
    digits[i] = static_cast<char>('0' + rest % 10);
  std::size_t end = digits.size();
  while (end > 2 && digits[end - 1] == '0') --end;
  out.append(digits.data(), end);
}

void append_text(std::string& out, std::string_view value) {
  const bool plain = std::all_of(value.begin(), value.end(),
                                 [](char c) { return c >= ' ' && c < 0x7F && c != '"' && c != '\\'; });
  if (!plain) {
    out += nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    return;
  }
  out += '"';
  out += value;
  out += '"';
}

std::string& ObjectText::begin(std::string_view key) {
  if (!first_) out_ += ',';
  first_ = false;
  out_ += '"';
  out_ += key;
  out_ += "\":";
  return out_;
}

ObjectText& ObjectText::text(std::string_view key, std::string_view value) {
  append_text(begin(key), value);
  return *this;
}

ObjectText& ObjectText::number(std::string_view key, std::optional<double> value, double factor) {
  append_number(begin(key), value ? std::optional(*value * factor) : std::nullopt);
  return *this;
}

ObjectText& ObjectText::integer(std::string_view key, std::optional<std::int64_t> value) {
  append_integer(begin(key), value);
  return *this;
}

ObjectText& ObjectText::boolean(std::string_view key, bool value) {
  begin(key) += value ? "true" : "false";
  return *this;
}

}  // namespace slipd
