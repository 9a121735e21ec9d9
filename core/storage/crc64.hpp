// CRC-64/XZ (docs/methods.md §35): finds the damage that disks and half-written files do. Not against malice.
#pragma once

#include <cstdint>
#include <span>

namespace slipd {

std::uint64_t crc64(std::span<const std::uint8_t> bytes) noexcept;

}  // namespace slipd
