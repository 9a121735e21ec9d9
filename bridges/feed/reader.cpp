#include "bridges/feed/reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "bridges/feed/document.hpp"

namespace slipd::feed {
namespace {

using nlohmann::json;

// What a double counts without a gap.
constexpr double kLargestCount = 9007199254740992.0;  // 2^53
// Of any clock, so that it can be counted in ns.
constexpr double kLargestTimeS = 4e9;

// Of numbers within each other: a list of lists.
constexpr int kMostLists = 2;

// Null: there is nothing.
const json* at(const json& document, const std::string& pointer) {
  try {
    const json::json_pointer where(pointer);
    return document.contains(where) ? &document.at(where) : nullptr;
  } catch (const json::exception&) {  // a pointer into a list by a word
    return nullptr;
  }
}

// Numbers between commas. A number of base 16 is whole.
bool split(std::string_view text, int base, std::vector<double>& out) {
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(','));
    double real = 0;
    std::int64_t whole = 0;
    const char* const end = word.data() + word.size();
    const auto read =
        base == 10 ? std::from_chars(word.data(), end, real) : std::from_chars(word.data(), end, whole, base);
    if (read.ec != std::errc() || read.ptr != end) return false;
    out.push_back(base == 10 ? real : static_cast<double>(whole));
    text.remove_prefix(std::min(word.size() + 1, text.size()));
  }
  return true;
}

// A number, a text of numbers, or lists of these, at most `lists` within each other. Stops when there are
// more than `most`.
bool flatten(const json& value, int base, std::size_t most, int lists, std::vector<double>& out) {
  if (value.is_number()) {
    out.push_back(value.get<double>());
    return true;
  }
  if (value.is_string()) return split(value.get_ref<const std::string&>(), base, out);
  if (!value.is_array() || lists == 0) return false;
  for (const json& element : value)
    if (out.size() > most || !flatten(element, base, most, lists - 1, out)) return false;
  return true;
}

// The bytes that the head says for a name.
bool named(const HeadList& head, const std::string& name, const json& document, Bytes body, Bytes& out) {
  const json* const list = at(document, head.pointer);
  if (list == nullptr || !list->is_array()) return false;
  for (const json& entry : *list) {
    if (!entry.is_object() || entry.value(head.name, json()) != name) continue;
    const json offset = entry.value(head.offset, json()), length = entry.value(head.length, json());
    if (!offset.is_number_integer() || !length.is_number_integer()) return false;
    const auto from = offset.get<std::int64_t>(), bytes = length.get<std::int64_t>();
    const auto size = static_cast<std::int64_t>(body.size());
    if (from < 0 || bytes < 0 || from > size || bytes > size - from) return false;
    out = body.subspan(static_cast<std::size_t>(from), static_cast<std::size_t>(bytes));
    return true;
  }
  return false;
}

bool exists(const Place& place, const HeadList& head, const json& document) {
  if (!place.at.empty()) return at(document, place.at) != nullptr;
  if (place.offset) return true;
  const json* const list = at(document, head.pointer);
  if (list == nullptr || !list->is_array()) return false;
  return std::any_of(list->begin(), list->end(), [&](const json& entry) {
    return entry.is_object() && entry.value(head.name, json()) == place.name;
  });
}

std::string describe(const Place& place) {
  if (!place.at.empty()) return place.at;
  return place.offset ? "offset " + std::to_string(*place.offset) : "\"" + place.name + "\"";
}

}  // namespace

bool Reader::numbers_in_bytes(const Place& place, Bytes bytes, std::size_t count, std::vector<double>& out) {
  if (bytes.size() != count * place.type.bytes) return false;
  for (std::size_t i = 0; i < count; ++i)
    out.push_back(wire::read_number(bytes.data() + i * place.type.bytes, place.type));
  return true;
}

bool Reader::numbers_at(const Place& place, const json& document, Bytes body, std::size_t count,
                        std::vector<double>& out) {
  out.clear();
  if (!place.at.empty()) {
    const json* const value = at(document, place.at);
    return value != nullptr && flatten(*value, place.base, count, kMostLists, out) && out.size() == count;
  }
  Bytes bytes;
  if (place.offset) {
    if (body.size() < *place.offset + place.behind) return false;
    bytes = body.subspan(*place.offset, body.size() - *place.offset - place.behind);
  } else if (!named(profile_.head, place.name, document, body, bytes)) {
    return false;
  }
  return numbers_in_bytes(place, bytes, count, out);
}

bool Reader::number_at(const Place& place, const json& document, Bytes body, double& out) {
  std::vector<double> one;
  if (place.offset) {  // what is behind it is no matter
    if (body.size() < *place.offset + place.type.bytes) return false;
    out = wire::read_number(body.data() + *place.offset, place.type);
    return std::isfinite(out);
  }
  if (!numbers_at(place, document, body, 1, one)) return false;
  out = one.front();
  return std::isfinite(out);
}

Outcome Reader::is_ours(const json& document, Bytes body) {
  if (!profile_.device.empty()) {
    const json* const name = at(document, profile_.device);
    const std::string text = name == nullptr     ? ""
                             : name->is_string() ? name->get<std::string>()
                                                 : name->dump();
    if (text != profile_.device_name)
      return refuse(Outcome::other, "the message is of the sensor \"" + text + "\", and \"device\" is \"" +
                                        profile_.device_name + "\"");
  }
  if (profile_.ready && exists(profile_.ready->of, profile_.head, document)) {
    double now = 0;
    if (!number_at(profile_.ready->of, document, body, now))
      return refuse(Outcome::corrupt, describe(profile_.ready->of) + " is no number");
    if (now != profile_.ready->is) return refuse(Outcome::other, "the device does not measure yet");
  }
  if (!exists(profile_.values, profile_.head, document))
    return refuse(Outcome::other, "the message has no " + describe(profile_.values));
  return Outcome::frame;
}

Outcome Reader::read(const Message& message, Reading& out) {
  json document;
  const bool parsed = profile_.format == Format::json        ? parse_json(message.body, document)
                      : profile_.format == Format::yaml_head ? parse_yaml(message.head, document)
                                                             : true;
  if (!parsed)
    return refuse(Outcome::corrupt,
                  std::string(profile_.format == Format::json ? "the message is no JSON text"
                                                              : "the head is no YAML text") +
                      ", or is nested more than " + std::to_string(kDeepestDocument) + " deep");
  if (const Outcome outcome = is_ours(document, message.body); outcome != Outcome::frame) return outcome;

  const std::size_t count = profile_.frames.taxels * static_cast<std::size_t>(profile_.frames.axes);
  std::vector<double> values;
  if (!numbers_at(profile_.values, document, message.body, count, values))
    return refuse(Outcome::corrupt,
                  describe(profile_.values) + " has not the " + std::to_string(count) + " numbers of " +
                      std::to_string(profile_.frames.taxels) + " taxels" +
                      (profile_.values.at.empty() ? "" : " in a text, a list or a list of lists"));
  out.values.clear();
  for (const double value : values) {
    out.values.push_back(static_cast<float>(value));
    if (!std::isfinite(out.values.back())) return refuse(Outcome::corrupt, "a value is not finite");
  }
  out.sequence.reset();
  out.sent_s.reset();
  double number = 0;
  if (profile_.sequence) {
    const std::size_t bytes = profile_.sequence->wrapping_bytes();
    if (!number_at(*profile_.sequence, document, message.body, number) ||
        (bytes == 0 && (number < 0 || number > kLargestCount)))
      return refuse(Outcome::corrupt, describe(*profile_.sequence) + " is no count");
    out.sequence = static_cast<std::uint64_t>(static_cast<std::int64_t>(number));
    out.sequence_bytes = bytes == 0 ? sizeof *out.sequence : bytes;
  }
  if (profile_.time) {
    if (!number_at(*profile_.time, document, message.body, number) ||
        std::abs(number * profile_.time_unit_s) > kLargestTimeS)
      return refuse(Outcome::corrupt, describe(*profile_.time) + " is no time");
    out.sent_s = number * profile_.time_unit_s;
    const std::size_t bytes = profile_.time->wrapping_bytes();
    out.sent_range_s = bytes == 0 ? 0 : std::exp2(8 * bytes) * profile_.time_unit_s;
  }
  return Outcome::frame;
}

}  // namespace slipd::feed
