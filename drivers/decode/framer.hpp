// Bytes in the pieces in which they arrive → packets, as the profile's `stream` says: frames between markers,
// of a length that is fixed or stated, with a checksum; within a frame one packet, tagged records, or
// Contactile's nested offsets. Without a stream each piece is a packet. Pure; acquire thread; allocates
// nothing after it is made.
//
// A frame that turns out wrong loses only its first byte: the next is looked for in what follows, so that
// garbage, a byte too few or a marker within data cost the frames that they hit and no more.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/decode/profile.hpp"

namespace slipd::decode {

struct RawPacket {
  std::uint32_t id = 0;  // the tag of a record; else 0
  std::span<const std::uint8_t> bytes;
};

struct FramerCounts {
  std::uint64_t frames = 0;   // whole and right
  std::uint64_t wrong = 0;    // began like one and were not, or made no sense inside
  std::uint64_t garbage = 0;  // bytes that belonged to no frame
};

class Framer {
 public:
  enum class Got : std::uint8_t { nothing, packet, wrong };

  explicit Framer(const Profile& profile);

  // More bytes have come. To be called when next() has said `nothing`; then all of them fit up to room().
  void put(std::span<const std::uint8_t> bytes) noexcept;
  std::size_t room() const noexcept { return most_; }

  // The next packet, its bytes valid until the next call of put; or that a frame or a run of garbage was
  // dropped; or nothing: more bytes are needed.
  Got next(RawPacket& out) noexcept;

  void reset() noexcept;  // forgets what has come
  const FramerCounts& counts() const noexcept { return counts_; }

 private:
  using Bytes = std::span<const std::uint8_t>;

  Bytes held() const noexcept { return Bytes(buffer_).subspan(used_, filled_ - used_); }
  std::size_t before_begin(bool& begun) const noexcept;
  bool lose(std::size_t bytes) noexcept;
  std::size_t size_of(Bytes from_begin) const noexcept;
  bool is_right(Bytes frame) const noexcept;
  Got unpack(Bytes frame, RawPacket& out) noexcept;
  Got next_record(RawPacket& out) noexcept;

  Stream stream_;
  bool framed_;
  std::size_t sensors_, pillars_;
  std::size_t most_;
  std::vector<std::uint8_t> buffer_, flat_;
  std::size_t used_ = 0, filled_ = 0;  // of the buffer
  std::size_t searched_ = 0;           // of what is held: no end marker begins before
  Bytes records_;                      // of the last frame, not told yet
  bool lost_ = true;                   // in garbage that is told already, as before the first frame
  std::size_t run_ = 0;                // bytes of garbage since it was told
  FramerCounts counts_;
};

}  // namespace slipd::decode
