// What a HID report descriptor says of the numbers in input reports: where each stands and what it measures.
// By this a profile can name a value by its usage (page 0x20, Sensors: 0x0494 is a force) and need not know
// the device. Pure; set-up thread. Source: Device Class Definition for HID 1.11, 6.2.2; HID Usage
// Tables 1.12.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "drivers/decode/profile.hpp"

namespace slipd::hid {

struct InputField {
  std::uint8_t report = 0;        // 0: the device numbers none
  std::uint32_t usage = 0;        // page << 16 | usage
  std::size_t bit = 0, bits = 0;  // within the report, behind its number
  bool is_signed = false;
  double newtons_a_count = 0;  // as a force: scaled as the descriptor says; without a unit it is the newton
  double zero_count = 0;       // the count of 0 N
};

// In the descriptor's order. One that ends in the middle of an item, nests deeper than any device's, or has
// more than 4096 fields says what it said until then.
std::vector<InputField> input_fields(std::span<const std::uint8_t> descriptor);

// Bytes of an input report, without its number.
std::size_t report_length(std::span<const std::uint8_t> descriptor, std::uint8_t report);

// Puts places, types and scales into the fields that the profile names by usage, once. Throws DriverError: a
// usage that the device has not, or one at a place that is no whole number of bytes.
void resolve_usages(decode::Profile& profile, std::span<const std::uint8_t> descriptor);

// That of /dev/hidrawN, from sysfs, since hidapi does not give it. Throws DriverError.
std::vector<std::uint8_t> descriptor_of(const std::filesystem::path& device);

}  // namespace slipd::hid
