// What the messages of a server or device are: a profile, as bridges/feed/message.schema.json describes its
// keys. Any thread that may allocate.
#pragma once

#include <cstddef>
#include <optional>
#include <slipd.hpp>
#include <string>

#include "wire/number.hpp"

namespace slipd::feed {

// A count in the header of a datagram.
struct HeaderCount {
  std::size_t offset = 0;  // from the datagram's begin, bytes
  wire::NumberType type;
};

// How a message is put together from datagrams.
struct Datagrams {
  std::size_t header = 0;  // in front of each datagram's content, bytes
  HeaderCount message;     // which message it belongs to
  HeaderCount part;        // its place in the message, from 0
  HeaderCount last;        // the place of the message's last one
};

enum class Format : unsigned char {
  json,      // a JSON text
  bytes,     // numbers at fixed places
  yaml_head  // the first datagram is a YAML text, which names the places in the others
};

// The list in a head of what the bytes are.
struct HeadList {
  std::string pointer;               // JSON pointer of the list
  std::string name, offset, length;  // keys of its entries; place and length in bytes
};

// Where a number, or the first of several, is in a message: exactly one of `at`, `offset` and `name`.
struct Place {
  std::string at;                     // JSON pointer; empty: not by a pointer
  int base = 10;                      // of numbers in a text
  std::optional<std::size_t> offset;  // in the bytes
  std::string name;                   // in the head's list; empty: not by a name
  wire::NumberType type;              // of numbers at an offset or name
  std::size_t behind = 0;             // bytes behind the last value at an offset
  // Of a count or clock here, after which it wraps. 0: in a text or a real, which do not.
  std::size_t wrapping_bytes() const noexcept {
    return at.empty() && type.kind != wire::NumberKind::real ? type.bytes : 0;
  }
};

// A number that messages have while the device measures.
struct Ready {
  Place of;
  double is = 0;
};

struct Profile {
  std::string from;  // where messages come from: ws://…, udp://…
  std::optional<Datagrams> datagrams;
  Format format = Format::json;
  HeadList head;                  // of a yaml_head
  std::string device;             // JSON pointer of the sensor's name; empty: all messages are of this sensor
  std::string device_name;        // what is there in messages of this sensor
  Place values;                   // taxels x axes numbers, those of one taxel side by side
  std::optional<Place> sequence;  // rises
  std::optional<Place> time;      // of the sender's clock
  double time_unit_s = 1;
  std::optional<Ready> ready;
  slipd_frames frames{};  // of the hello to slipd; 0 taxels: the settings give the number
};

// What of the settings changes a profile.
struct Instance {
  std::string device;      // empty: the profile's usual one
  std::size_t taxels = 0;  // 0: the profile's
};

// Throws SettingsError, one line for each error.
Profile parse_profile(const std::string& text, const std::string& name, const Instance& instance);

// Reads the file `name`, if it has a slash. Else reads NAME.json from /etc/slipd/feeds, else from the shipped
// profiles. Throws SettingsError.
Profile find_profile(const std::string& name, const Instance& instance);

}  // namespace slipd::feed
