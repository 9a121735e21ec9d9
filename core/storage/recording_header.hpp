// A recording's header to and from the bytes of one CBOR item. Set-up only; see recording.hpp for its form.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/storage/recording.hpp"

namespace slipd {

inline constexpr std::size_t kRecordingMaxHeaderBytes = std::size_t{1} << 20;

// Throws std::invalid_argument for a layout too large to record.
std::vector<std::uint8_t> encode_header(const RecordingHeader& header);

// `item`: one whole CBOR item. Throws std::invalid_argument that says what was expected and what is there
// instead.
RecordingHeader decode_header(std::span<const std::uint8_t> item);

}  // namespace slipd
