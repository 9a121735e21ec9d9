// Encodes and decodes a recording's header, one CBOR item; recording.hpp describes its form. Called while
// setting up, from any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/storage/recording.hpp"

namespace slipd {

// Longest header that is read, bytes.
inline constexpr std::size_t kRecordingMaxHeaderBytes = std::size_t{1} << 20;

// Throws std::invalid_argument for a layout that is too large to record. Longer names and descriptions are
// cut to 4096 bytes.
std::vector<std::uint8_t> encode_header(const RecordingHeader& header);

// `item`: one whole CBOR item. Throws std::invalid_argument with what was expected and what was found.
RecordingHeader decode_header(std::span<const std::uint8_t> item);

}  // namespace slipd
