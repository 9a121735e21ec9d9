// XXH3-64 (docs/methods.md §35): finds damage in what is written and read at the rate of frames, at the speed
// of memory. Not against malice. crc64.hpp is for small files.
#pragma once

#include <cstdint>
#include <span>

namespace slipd {

std::uint64_t xxh3(std::span<const std::uint8_t> bytes) noexcept;

}  // namespace slipd
