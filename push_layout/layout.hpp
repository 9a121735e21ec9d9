// Frames from a program, as it sends them to the driver `push`: a hello, then frames, each one message of a
// Unix socket (SOCK_SEQPACKET). docs/push.md states every byte. All numbers are little-endian; a machine that
// is not cannot build it.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace slipd::push_layout {

static_assert(std::endian::native == std::endian::little);

inline constexpr std::array<char, 8> kMagic{'s', 'l', 'i', 'p', 'p', 'u', 's', 'h'};
// Rises when a field changes its place or meaning.
inline constexpr std::uint16_t kVersion = 1;
// Bytes of the longest message: what Linux takes without a privilege (net.core.wmem_max of 212992 bytes, less
// what it keeps of it). 17704 taxels of three axes.
inline constexpr std::size_t kLongestMessage = 208 * 1024 - 512;

// What the values of frames are.
enum class Unit : std::uint8_t {
  unsaid = 0,      // as configured
  pascal = 1,      // pressure and shear of each taxel, Pa
  newton = 2,      // force on each taxel, N
  counts = 3,      // a converter's counts
  microtesla = 4,  // the field at a magnetometer, µT
  // How far points of a surface have moved. Along x and y: mm from their place at rest, NaN where a point is
  // not seen. Third: how much the picture around it has changed since rest, 0 to 1.
  millimetre = 5
};

// What frames read without load.
enum class Zero : std::uint8_t {
  unsaid = 0,    // as configured
  measured = 1,  // anything: slipd measures it
  zero = 2       // 0
};

// The first message.
struct Hello {
  std::array<char, 8> magic = kMagic;
  std::uint16_t version = kVersion;
  std::uint8_t axes =
      3;  // values of each taxel: 3, along x, y and z, or 1, along z; z is positive when pressed
  Unit unit = Unit::unsaid;
  std::uint32_t taxels = 0;
  double rate_hz = 0;  // frames a second; 0: unsaid
  Zero zero = Zero::unsaid;
  std::array<std::uint8_t, 7> reserved{};  // 0
};
static_assert(sizeof(Hello) == 32 && std::is_trivially_copyable_v<Hello>);

// What slipd answers to the hello, and says before it ends a connection: a number of 32 bits, then a text for
// people in UTF-8, without a zero byte at its end.
enum class Answer : std::uint32_t {
  accepted = 0,
  refused = 1,  // the hello contradicts the configuration, or is none
  busy = 2,     // another writer sends this sensor's frames
  replaced = 3  // this writer was silent, and another one has come
};
inline constexpr std::size_t kLongestAnswer = 512;

// The head of each message after the hello. taxels x axes values of float32 follow, those of one taxel side
// by side.
struct FrameHead {
  std::uint16_t version = kVersion;
  std::uint16_t flags = 0;     // kBad, or 0
  std::uint32_t size = 0;      // of the whole message, bytes
  std::uint64_t sequence = 0;  // rises; a jump by n is n - 1 lost frames
  std::int64_t time_ns = 0;    // of the sample, CLOCK_MONOTONIC; 0: now
};
static_assert(sizeof(FrameHead) == 24 && std::is_trivially_copyable_v<FrameHead>);

// The writer knows that this frame is no sample: it is counted and not used.
inline constexpr std::uint16_t kBad = 1;

// Bytes of a whole frame.
constexpr std::size_t frame_size(std::size_t taxels, std::size_t axes) noexcept {
  return sizeof(FrameHead) + taxels * axes * sizeof(float);
}

}  // namespace slipd::push_layout
