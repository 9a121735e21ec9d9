// Encodes and decodes a recording's header, one CBOR item; recording.hpp describes its form. Called while
// setting up, from any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/recording/recording.hpp"

namespace slipd {

// Longest header that is read, bytes.
inline constexpr std::size_t kRecordingMaxHeaderBytes = std::size_t{1} << 20;

// A header of version 2. Throws std::invalid_argument for a layout that is too large to record. Longer names
// and descriptions are cut to 4096 bytes.
std::vector<std::uint8_t> encode_header(const RecordingHeader& header);

struct DecodedHeader {
  RecordingHeader header;
  // Version of the recording's form: 1 or 2.
  int version = 2;
};
// `item`: one whole CBOR item. Throws std::invalid_argument with what was expected and what was found.
DecodedHeader decode_header(std::span<const std::uint8_t> item);

}  // namespace slipd
