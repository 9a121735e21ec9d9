// A sensor's zero on disk: CBOR with a checksum, in a file of its own, written whole or not at all. Set-up
// threads and the keeper of zeros; may wait for the disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/bias/bias.hpp"
#include "daemon/rt/clock.hpp"

namespace slipd {

// Whose zero it is. What the device says of itself where it can, so that it is known on another port and
// under another name.
struct BiasIdentity {
  std::string driver, profile;
  std::string device;  // its serial, else how the configuration finds it
  std::string part;    // which of its sensors
  std::size_t taxels = 0;
  bool operator==(const BiasIdentity&) const = default;
};

std::string to_string(const BiasIdentity& identity);  // for people, one line

// `FILE: why it is not used`.
class BiasError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Times are kept as CLOCK_REALTIME; `now` is one moment on both clocks. decode throws BiasError for bytes
// that are damaged, cut, of another version, or another sensor's.
std::vector<std::uint8_t> encode_zero(const BiasIdentity& identity, const Bias& zero, const Now& now);
Bias decode_zero(std::span<const std::uint8_t> bytes, const BiasIdentity& identity, const Now& now);

// Where it is kept: in the folder `zero` of the state folder. Throws as state_folder does.
std::filesystem::path zero_file(const BiasIdentity& identity);

// None: there is no such file. Throws BiasError.
std::optional<Bias> load_zero(const std::filesystem::path& file, const BiasIdentity& identity);

// Throws std::runtime_error.
void save_zero(const std::filesystem::path& file, const BiasIdentity& identity, const Bias& zero);

}  // namespace slipd
