// Encodes and decodes one frame of a recording; recording.hpp describes its form. Neither allocates nor
// throws. Not thread-safe for one frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/frame/frame.hpp"
#include "core/recording/recording.hpp"
#include "core/storage/cbor.hpp"

namespace slipd {

// Bytes of an encoded frame of so many taxels at most.
std::size_t largest_frame_bytes(std::size_t taxels) noexcept;

// Writes `frame`, and its estimate unless that is null.
void put_frame(cbor::Writer& out, const FrameSlot& frame, const RecordedEstimate* estimate) noexcept;

// Reads a frame into `out`, whose spans have the layout's size, and its estimate, if `estimate` is not null.
// Returns what was expected at a fault, null without one; in.position() and in.starved() say more.
const char* take_frame(cbor::Reader& in, FrameSlot& out, std::optional<RecordedEstimate>* estimate) noexcept;

}  // namespace slipd
