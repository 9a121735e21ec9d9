// Frames from a program, as it sends them to the driver `push`: a hello, then frames, each one message of a
// Unix socket (SOCK_SEQPACKET); the values of large frames lie in shared memory. docs/push.md states every
// byte. All numbers are little-endian; a machine that is not cannot build it.
#pragma once

#include <array>
#include <atomic>
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
  std::uint16_t flags = 0;     // kBad, kInRing
  std::uint32_t size = 0;      // of the whole message, bytes
  std::uint64_t sequence = 0;  // rises; a jump by n is n - 1 lost frames
  std::int64_t time_ns = 0;    // of the sample, CLOCK_MONOTONIC; 0: now
};
static_assert(sizeof(FrameHead) == 24 && std::is_trivially_copyable_v<FrameHead>);

// The writer knows that this frame is no sample: it is counted and not used.
inline constexpr std::uint16_t kBad = 1;
// The message is a Notice: the values are in the ring.
inline constexpr std::uint16_t kInRing = 2;

// Shared memory for the values of one writer's frames. slipd makes it and gives its descriptor with the
// answer `accepted`; no other writer gets the same. Values that are smaller, bytes, have no ring: measured, a
// message that is copied twice then takes no longer.
inline constexpr std::size_t kSmallestInRing = 16 * 1024;
// Slots. Fewer: a writer that is ahead of slipd sooner sends frames by the socket. More: values that slipd
// reads have left the processor's caches.
inline constexpr std::uint32_t kRingSlots = 4;
inline constexpr std::array<char, 8> kRingMagic{'s', 'l', 'i', 'p', 'r', 'i', 'n', 'g'};

// At offset 0.
struct RingHeader {
  std::array<char, 8> magic = kRingMagic;
  std::uint16_t version = kVersion;
  std::uint16_t reserved = 0;
  std::uint32_t slots = kRingSlots;
  std::uint64_t slot_bytes = 0;  // from one slot to the next
  // Number of the last frame in the ring that slipd does not read any more; slipd writes it, the writer reads
  // it.
  alignas(64) std::atomic<std::uint64_t> taken{0};
};
static_assert(sizeof(RingHeader) == 128 && offsetof(RingHeader, taken) == 64);

// Slot n % slots holds frame n of the ring; frames count from 1. The values are behind it.
struct alignas(64) RingSlot {
  std::atomic<std::uint64_t> frame{0};  // whose values are whole; 0: none, or they are being written
};
static_assert(sizeof(RingSlot) == 64 && std::atomic<std::uint64_t>::is_always_lock_free);

constexpr std::size_t ring_slot_bytes(std::size_t values_bytes) noexcept {
  return sizeof(RingSlot) + (values_bytes + 63) / 64 * 64;
}
constexpr std::size_t ring_bytes(std::size_t values_bytes) noexcept {
  return sizeof(RingHeader) + kRingSlots * ring_slot_bytes(values_bytes);
}

// The message of a frame whose values are in the ring.
struct Notice {
  FrameHead head;           // flags: kInRing
  std::uint64_t frame = 0;  // of the ring
};
static_assert(sizeof(Notice) == 32 && std::is_trivially_copyable_v<Notice>);

// Bytes of a whole frame.
constexpr std::size_t frame_size(std::size_t taxels, std::size_t axes) noexcept {
  return sizeof(FrameHead) + taxels * axes * sizeof(float);
}

}  // namespace slipd::push_layout
