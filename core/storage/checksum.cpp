#include "core/storage/checksum.hpp"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace slipd {

std::uint64_t xxh3(std::span<const std::uint8_t> bytes) noexcept {
  return XXH3_64bits(bytes.data(), bytes.size());
}

}  // namespace slipd
