// The checksum of slipd's own files.
#include "core/storage/crc64.hpp"

#include <gtest/gtest.h>

#include <string_view>
#include <vector>

namespace slipd {
namespace {

std::uint64_t of(std::string_view text) {
  return crc64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

// The check value of CRC-64/XZ (ECMA-182, reflected).
TEST(Crc64, IsThatOfXz) {
  EXPECT_EQ(of("123456789"), 0x995DC9BBDF1939FAU);
  EXPECT_EQ(of(""), 0U);
}

TEST(Crc64, DetectsEachFlippedBit) {
  std::vector<std::uint8_t> bytes(40, 0x5A);
  const std::uint64_t whole = crc64(bytes);
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    EXPECT_NE(crc64(bytes), whole) << bit;
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
  }
}

}  // namespace
}  // namespace slipd
