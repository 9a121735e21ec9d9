#include "schema/json_text.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace slipd {
namespace {

using nlohmann::json;

// An iterator over the text that records in `trace` how far the parser has read.
class Cursor {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  Cursor(const char* at, const char** trace) : at_(at), trace_(trace) {}
  reference operator*() const { return *at_; }
  Cursor& operator++() {
    *trace_ = ++at_;
    return *this;
  }
  bool operator==(const Cursor& other) const { return at_ == other.at_; }
  bool operator!=(const Cursor& other) const { return at_ != other.at_; }

 private:
  const char* at_;
  const char** trace_;
};

JsonTextError error_at(std::string_view text, std::size_t consumed, const std::string& what) {
  const std::string_view before = text.substr(0, consumed == 0 ? 0 : std::min(consumed, text.size()) - 1);
  const auto line = 1 + static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n'));
  const std::size_t start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
  const auto continues = [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; };
  const auto column = 1 + std::count_if(before.begin() + static_cast<std::ptrdiff_t>(start), before.end(),
                                        [&](char c) { return !continues(c); });
  return {line, static_cast<std::size_t>(column), what};
}

// "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error …" → "syntax error …", at
// most 240 bytes.
std::string own_words(std::string text) {
  const auto cut_behind = [&](std::string_view mark) {
    if (const auto at = text.find(mark); at != std::string::npos) text.erase(0, at + mark.size());
  };
  cut_behind("] ");
  if (text.starts_with("parse error at")) cut_behind(": ");
  constexpr std::size_t kLongest = 240;
  if (text.size() > kLongest) text.replace(kLongest, std::string::npos, "…");
  return text;
}

// The events of nlohmann's SAX interface. A handler that returns false ends the parse.
class Builder {
 public:
  Builder(std::string_view text, const char* const* trace) : text_(text), trace_(trace) {}

  bool null() { return add(nullptr); }
  bool boolean(bool v) { return add(v); }
  bool number_integer(std::int64_t v) { return add(v); }
  bool number_unsigned(std::uint64_t v) { return add(v); }
  bool number_float(double v, const std::string&) { return add(v); }
  bool string(std::string& v) { return add(std::move(v)); }
  bool binary(json::binary_t&) { return refuse("binary data"); }
  bool start_object(std::size_t) { return open(json::object()); }
  bool start_array(std::size_t) { return open(json::array()); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }
  bool key(std::string& name) {
    if (open_.back()->contains(name))
      return refuse("key " + json(name).dump() + " is given twice in one object");
    key_ = name;
    return true;
  }
  bool parse_error(std::size_t consumed, const std::string&, const json::exception& e) {
    error_ = error_at(text_, consumed, own_words(e.what()));
    return false;
  }

  json result() && {
    if (error_) throw JsonTextError(*error_);
    return std::move(root_);
  }

 private:
  json* place(json&& v) {
    if (open_.empty()) return &(root_ = std::move(v));
    json& parent = *open_.back();
    if (!parent.is_object()) {
      parent.push_back(std::move(v));
      return &parent.back();
    }
    return &(parent[key_] = std::move(v));
  }
  bool add(json v) {
    place(std::move(v));
    return true;
  }
  // Pointers in open_ stay valid: a container grows only while nothing within it is open.
  bool open(json v) {
    if (open_.size() >= kJsonDepth)
      return refuse("nested deeper than " + std::to_string(kJsonDepth) + " levels");
    open_.push_back(place(std::move(v)));
    return true;
  }
  bool close() {
    open_.pop_back();
    return true;
  }
  bool refuse(const std::string& what) {
    error_ = error_at(text_, static_cast<std::size_t>(*trace_ - text_.data()), what);
    return false;
  }

  std::string_view text_;
  const char* const* trace_;
  json root_;
  std::vector<json*> open_;
  std::string key_;
  std::optional<JsonTextError> error_;
};

}  // namespace

std::string plain(std::string_view text) {
  constexpr unsigned char kDelete = 0x7F, kC1Lead = 0xC2, kC1Low = 0x80, kC1High = 0x9F;
  std::string out;
  const auto escape = [&](unsigned char c) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    out += {'\\', 'u', '0', '0', kDigits[c >> 4U], kDigits[c & 15U]};
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : '\0');
    if (c == kC1Lead && next >= kC1Low && next <= kC1High) {
      escape(next);
      ++i;
    } else if (c < ' ' || c == kDelete) {
      escape(c);
    } else {
      out += text[i];
    }
  }
  return out;
}

std::string JsonTextError::located_in(const std::string& file) const {
  return plain(file + ":" + std::to_string(line_) + ":" + std::to_string(column_) + ": " + what());
}

json parse_json_text(std::string_view text) {
  const char* trace = text.data();
  Builder builder(text, &trace);
  json::sax_parse(Cursor(text.data(), &trace), Cursor(text.data() + text.size(), &trace), &builder,
                  nlohmann::detail::input_format_t::json, true, true);
  return std::move(builder).result();
}

}  // namespace slipd
