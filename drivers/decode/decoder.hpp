// Packets of one sensor → its frames, as the profile says. Pure: no clock, no device, no allocation after it
// is made. Acquire thread.
//
// Most devices number neither their packets nor their scans, so only order and time tell which packets belong
// together: a scan begins with its first packet and must go on in the profile's order within its time-out.
// Anything else (a packet lost, twice, too early, of the wrong length) drops the whole scan, which then is
// missing from the sequence. Where the device counts its scans, the sequence follows that count.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/decode/profile.hpp"

namespace slipd::decode {

enum class Outcome : std::uint8_t {
  foreign,  // not this sensor's
  partial,  // taken, the scan is not whole yet
  frame,    // the slot holds a frame
  dropped   // the scan is lost, or the packet makes no sense
};

struct Counts {
  std::uint64_t packets = 0;     // that were this sensor's
  std::uint64_t malformed = 0;   // packets of a wrong length or without meaning
  std::uint64_t incomplete = 0;  // scans that were begun and dropped
  std::uint64_t stray = 0;       // packets that continued no scan
  std::uint64_t repeated = 0;    // scans that the device's counter says were there already, or come too late
};

class Decoder {
 public:
  // `sensor`: which of the device's; `board`: what the ids carry where the profile says so.
  Decoder(const Profile& profile, std::size_t sensor, unsigned board);

  // `time_ns`: arrival, of any one clock. The slot has the layout's size and stays the same until a frame is
  // told. Its time is that of the scan's first packet.
  Outcome take(std::uint32_t id, std::span<const std::uint8_t> bytes, std::int64_t time_ns,
               FrameSlot& slot) noexcept;

  // A packet was lost on the way, nobody knows of which scan: the one begun, or the one that it was.
  void spoil() noexcept;

  void reset() noexcept;  // forgets a scan begun, after the device was opened anew
  const Counts& counts() const noexcept { return counts_; }
  const std::vector<PacketRule>& rules() const noexcept { return rules_; }  // with the board in the ids

 private:
  bool matches(const PacketRule& rule, std::uint32_t id, std::span<const std::uint8_t> bytes) const noexcept;
  bool of_another_scan(std::span<const std::uint8_t> bytes) const noexcept;
  void drop() noexcept;
  bool follow_counter() noexcept;
  std::int64_t device_time_ns() noexcept;
  static bool fill(const PacketRule& rule, std::span<const std::uint8_t> bytes, FrameSlot& slot) noexcept;

  std::vector<PacketRule> rules_;
  SensorClass sensor_class_;
  std::int64_t timeout_ns_;
  std::optional<std::size_t> key_offset_;
  std::uint8_t key_ = 0;  // of the scan begun
  std::size_t next_ = 0;  // rule that continues the scan; 0: none is begun
  std::int64_t begun_ns_ = 0;
  std::uint64_t sequence_ = 0;
  // A number of the device that goes round: of the scan begun, and of the one before that counts.
  struct Round {
    std::optional<RoundNumber> rule;
    std::uint64_t now = 0;
    std::optional<std::uint64_t> last;
    void read(const std::optional<RoundNumber>& rule, std::span<const std::uint8_t> bytes) noexcept;
    // From the last one to this, which becomes the last; none: there was none, or it went back.
    std::optional<std::uint64_t> step() noexcept;
  };
  Round clock_, counter_;
  double clock_ns_ = 0;
  std::uint64_t told_ = 0;  // the last frame's sequence
  Counts counts_;
};

// The id with the board's number in it.
std::uint32_t addressed(std::uint32_t id, const std::optional<unsigned>& board_shift,
                        unsigned board) noexcept;

}  // namespace slipd::decode
