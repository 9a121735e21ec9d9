// Cuts a stream of bytes into packets, as the profile's `stream` describes it: frames between markers, of a
// fixed or a stated length, with a checksum; within a frame one packet, tagged records, or Contactile's
// nested offsets. Without a stream each chunk of bytes is a packet. Pure; acquire thread; allocates nothing
// after construction.
//
// Of an invalid frame only the first byte is discarded, and the search goes on in the bytes behind it. So
// garbage, a missing byte or a marker within data costs only the frames in which it occurs. Where
// only end markers tell where frames begin, the bytes up to the first one are dropped: they may be the rest
// of a frame.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/decode/profile.hpp"

namespace slipd::decode {

struct RawPacket {
  std::uint32_t id = 0;                 // the tag of a record; 0 where the frame is one packet
  std::span<const std::uint8_t> bytes;  // valid until the next put()
};

struct FramerCounts {
  std::uint64_t frames = 0;   // complete frames with the right length and checksum
  std::uint64_t invalid = 0;  // runs of garbage and frames whose content could not be decoded
  std::uint64_t garbage = 0;  // bytes that belonged to no frame
};

class Framer {
 public:
  enum class Result : std::uint8_t { incomplete, packet, invalid };

  explicit Framer(const Profile& profile);

  // Appends bytes that have arrived, at most room() of them. Call it only after next() returned `incomplete`.
  void put(std::span<const std::uint8_t> bytes) noexcept;
  std::size_t room() const noexcept { return capacity_; }

  // packet: `out` holds the next one. invalid: a frame or a run of garbage was discarded. incomplete: more
  // bytes are needed.
  Result next(RawPacket& out) noexcept;

  void reset() noexcept;  // forgets all bytes
  const FramerCounts& counts() const noexcept { return counts_; }

 private:
  using Bytes = std::span<const std::uint8_t>;

  Bytes held() const noexcept { return Bytes(buffer_).subspan(used_, filled_ - used_); }
  std::size_t before(Bytes marker, bool& found) const noexcept;
  bool lose(std::size_t bytes) noexcept;
  std::size_t size_of(Bytes from_begin) const noexcept;
  bool is_right(Bytes frame) const noexcept;
  Result unpack(Bytes frame, RawPacket& out) noexcept;
  Result next_record(RawPacket& out) noexcept;

  Stream stream_;
  bool framed_;
  std::size_t sensors_, pillars_;
  std::size_t capacity_;
  std::vector<std::uint8_t> buffer_, flat_;
  std::size_t used_ = 0, filled_ = 0;   // begin and end of the held bytes in the buffer
  std::size_t searched_ = 0;            // no end marker begins in so many of the held bytes
  Bytes records_;                       // records of the last frame that next() has not returned yet
  bool between_frames_ = false;         // false: in the middle of a frame that only an end marker ends
  bool in_garbage_ = true;              // in a run of garbage that was reported; also before the first frame
  std::size_t unreported_garbage_ = 0;  // bytes of garbage since the last report
  FramerCounts counts_;
};

}  // namespace slipd::decode
