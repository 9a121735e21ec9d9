#include "core/storage/crc64.hpp"

#include <boost/crc.hpp>

namespace slipd {
namespace {

using Crc64Xz = boost::crc_optimal<64, 0x42F0E1EBA9EA3693ULL, ~0ULL, ~0ULL, true, true>;

}  // namespace

std::uint64_t crc64(std::span<const std::uint8_t> bytes) noexcept {
  Crc64Xz crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

}  // namespace slipd
