// The bytes of one input within the envelope of slipd's own files, with a matching checksum, so that what
// follows the checksum is fuzzed as well.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/storage/crc64.hpp"

namespace slipd::fuzz {

inline std::vector<std::uint8_t> sealed(const char* format, int version, std::vector<std::uint8_t> body) {
  const std::uint64_t checksum = crc64(body);
  return nlohmann::json::to_cbor({{"format", format},
                                  {"version", version},
                                  {"crc64", checksum},
                                  {"body", nlohmann::json::binary(std::move(body))}});
}

}  // namespace slipd::fuzz
