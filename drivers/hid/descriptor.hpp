// Parses a HID report descriptor: the place and the meaning of each number in input reports. With it a
// profile names a value by its usage (page 0x20, Sensors: 0x0494 is a force) for any device that has it.
// Pure; set-up thread. Source: Device Class Definition for HID 1.11, 6.2.2; HID Usage Tables 1.12.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "drivers/decode/profile.hpp"

namespace slipd::hid {

struct Range {
  std::int64_t minimum = 0, maximum = 0;
  bool is_empty() const noexcept { return maximum <= minimum; }
  bool operator==(const Range&) const = default;
};

struct InputField {
  std::uint8_t report = 0;  // report id; 0: the device's reports have none
  std::uint32_t usage = 0;  // page << 16 | usage
  std::size_t bit = 0;      // first bit in the report, counted behind the report id
  std::size_t bits = 0;     // number of bits
  bool is_signed = false;   // two's complement
  Range logical;            // counts
  Range physical;           // what the counts stand for, in the field's unit; 0 to 0: the counts themselves
  double newtons_a_count = 0;  // scale of a force by the descriptor; a field without unit counts as newtons
  double zero_count = 0;       // the count at 0 N
};

// The fields in the descriptor's order. Parsing stops without an error where the descriptor ends within an
// item, nests too deep, or has more than 4096 fields.
std::vector<InputField> input_fields(std::span<const std::uint8_t> descriptor);

// The length of an input report in bytes, without its id.
std::size_t report_length(std::span<const std::uint8_t> descriptor, std::uint8_t report);

// Fills in offset, type and scale of the fields that the profile names by usage. Throws DriverError for a
// usage that the device does not have, one that is not aligned to bytes, or one whose range is empty; for
// usages of one packet in different reports; and for anything of the packet that lies behind the report's
// end.
void resolve_usages(decode::Profile& profile, std::span<const std::uint8_t> descriptor);

// Reads the descriptor of /dev/hidrawN from sysfs, because hidapi does not provide it. Throws DriverError.
std::vector<std::uint8_t> descriptor_of(const std::filesystem::path& device);

}  // namespace slipd::hid
