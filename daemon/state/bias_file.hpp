// A sensor's bias on disk: one file a sensor, CBOR with a checksum, replaced atomically. Called from acquire
// threads while they set up and from the bias store; may wait for the disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/zero/bias.hpp"
#include "daemon/rt/clock.hpp"

namespace slipd {

// Identifies a sensor independently of its configured name and of its port, if the device has a serial
// number.
struct BiasIdentity {
  // The driver's name.
  std::string driver;
  // The device profile; empty: none.
  std::string profile;
  // The device's serial number, else how the configuration finds it.
  std::string device;
  // Which of the device's sensors.
  std::string part;
  // Number of taxels, at least 1.
  std::size_t taxels = 0;
  // Whether another sensor in the same place has the same identity, because the device has no serial number.
  bool exchangeable() const { return !device.starts_with("serial "); }
  bool operator==(const BiasIdentity&) const = default;
};

// For people, one line.
std::string to_string(const BiasIdentity& identity);

// what() is `FILE: why it is not used`.
class BiasError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The file's bytes. Times are stored as CLOCK_REALTIME and converted by `now`. decode_bias throws BiasError
// for bytes that are damaged, cut, of another version, or of another sensor.
std::vector<std::uint8_t> encode_bias(const BiasIdentity& identity, const Bias& zero, const Now& now);
Bias decode_bias(std::span<const std::uint8_t> bytes, const BiasIdentity& identity, const Now& now);

// The sensor's file, in the folder `zero` of the state folder. Throws as state_folder does.
std::filesystem::path bias_file_path(const BiasIdentity& identity);

// Reads the file; none: there is no file. Throws BiasError if it cannot be used.
std::optional<Bias> load_bias(const std::filesystem::path& file, const BiasIdentity& identity);

// Replaces the file, creates the folder. Throws std::runtime_error.
void save_bias(const std::filesystem::path& file, const BiasIdentity& identity, const Bias& zero);

}  // namespace slipd
