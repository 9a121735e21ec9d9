// A small reader of DBC files for tests: messages, signals, value tables. Reads the statements that
// slipd.dbc has. Throws std::runtime_error with the line of an invalid statement.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace slipd::testing {

struct DbcSignal {
  unsigned start = 0, length = 0;
  bool little_endian = true, is_signed = false;
  double scale = 1, offset = 0, low = 0, high = 0;
  std::string unit, comment;
  std::map<std::uint64_t, std::string> values;

  std::uint64_t raw(const std::array<std::uint8_t, 8>& data) const;  // Intel byte order
  double physical(const std::array<std::uint8_t, 8>& data) const {
    return static_cast<double>(raw(data)) * scale + offset;
  }
};

struct DbcMessage {
  std::uint32_t id = 0;  // without the flag for 29 bits
  bool extended = false;
  std::string name, comment;
  unsigned length = 0;
  std::map<std::string, DbcSignal> signals;
  std::map<std::string, int> attributes;
};

// The messages by identifier.
std::map<std::uint32_t, DbcMessage> read_dbc(const std::string& text);

}  // namespace slipd::testing
