// Converts packets of Contactile's PTS 2.0, in which each packet states the offsets of its values, to packets
// with fixed offsets that a profile can name. Pure; acquire thread.
//
// In: width of offsets W (1, 2 or 4), a table of {type u16, offset W} up to the first of the offsets, zeros
// between, blocks; all little-endian, every offset counted from W. Type 1 is u32 counter, u64 µs. Type 3 is
// the number of sensors and an offset for each, there the number of pillars and an offset for each, there u16
// 2 and six floats: force x, y, z in N, displacement in mm. Counts are W wide. Other types are ignored.
// Out: counter 4 bytes, µs 8, then sensor by sensor and pillar by pillar the six floats, 24 bytes. A sensor
// that is not plugged in is NaN, and the decoder makes no frame of NaN.
// Source: a third party's description of a recorded stream.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace slipd::decode {

inline constexpr std::size_t kPts2Head = 12, kPts2Pillar = 24;

// `out`: kPts2Head + sensors * pillars * kPts2Pillar bytes. False: `in` is malformed or a sensor has another
// number of pillars; then `out` is invalid.
bool flatten_pts2(std::span<const std::uint8_t> in, std::size_t sensors, std::size_t pillars,
                  std::span<std::uint8_t> out) noexcept;

}  // namespace slipd::decode
