// Assembles the packets of one sensor into frames, as the profile describes them. Pure: no clock, no device,
// no allocation after construction. Acquire thread.
//
// Most devices number neither their packets nor their scans. Then only order and time assign packets to
// scans: a scan begins with its first packet and must continue in the profile's order within its time-out.
// Anything else (a packet lost, repeated, too early, of the wrong length) drops the whole scan, and its
// sequence number is skipped. Where the device counts its scans, the sequence follows that count.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/decode/profile.hpp"

namespace slipd::decode {

enum class Outcome : std::uint8_t {
  foreign,  // the packet is of another sensor
  partial,  // accepted; the scan is incomplete
  frame,    // the slot holds a frame
  dropped   // the scan is lost, or the packet is malformed
};

struct DecoderCounts {
  std::uint64_t packets = 0;     // packets of this sensor
  std::uint64_t malformed = 0;   // packets of a wrong length or with values that are not finite
  std::uint64_t incomplete = 0;  // scans that began and were dropped
  std::uint64_t stray = 0;       // packets that continued no scan
  std::uint64_t repeated = 0;    // scans whose device count had come before, or went back
};

// A packet that no rule of a profile describes.
struct Misfit {
  std::uint32_t id = 0;
  std::size_t bytes = 0;
};

class Decoder {
 public:
  // `sensor`: index among the device's sensors, from 0. `board`: the number that the ids contain where a rule
  // has a board_shift.
  Decoder(const Profile& profile, std::size_t sensor, unsigned board);

  // `time_ns`: time of arrival, of any one clock. `slot` has the layout's size and must be the same one until
  // the outcome is `frame`. The frame's time is that of the scan's first packet.
  Outcome take(std::uint32_t id, std::span<const std::uint8_t> bytes, std::int64_t time_ns,
               FrameSlot& slot) noexcept;

  // A packet was lost in transmission. Drops the scan that has begun; where a scan is one packet, skips a
  // sequence number.
  void mark_packet_lost() noexcept;

  void reset() noexcept;  // forgets a scan that has begun; for a device that was opened again
  const DecoderCounts& counts() const noexcept { return counts_; }
  const std::vector<PacketRule>& rules() const noexcept { return rules_; }  // with the board in the ids

  // The last packet whose id, or whose length, is no rule's; none: there was none. After construction or
  // reset.
  const std::optional<Misfit>& misfit() const noexcept { return misfit_; }
  // How misfit() differs from the rules, for people; empty: there is none. `packets`: what the bus calls
  // them.
  std::string why_no_frames(const std::string& packets) const;

 private:
  bool matches(const PacketRule& rule, std::uint32_t id, std::span<const std::uint8_t> bytes) const noexcept;
  bool fits_some_rule(std::uint32_t id, std::size_t bytes) const noexcept;
  bool of_another_scan(std::span<const std::uint8_t> bytes) const noexcept;
  void drop() noexcept;
  Outcome drop_malformed() noexcept;
  bool follow_counter() noexcept;
  std::int64_t device_time_ns() noexcept;
  static bool fill(const PacketRule& rule, std::span<const std::uint8_t> bytes, FrameSlot& slot) noexcept;

  std::vector<PacketRule> rules_;
  SensorClass sensor_class_;
  std::int64_t timeout_ns_;
  std::optional<std::size_t> key_offset_;
  std::uint8_t key_ = 0;  // of the scan that has begun
  std::size_t next_ = 0;  // index of the rule that continues the scan; 0: no scan has begun
  std::int64_t begun_ns_ = 0;
  std::uint64_t sequence_ = 0;
  // A number of the device that wraps around: its value in the present scan and in the last complete one.
  struct WrappingCounter {
    std::optional<WrappingNumber> rule;
    std::uint64_t now = 0;
    std::optional<std::uint64_t> last;
    void read(const std::optional<WrappingNumber>& rule, std::span<const std::uint8_t> bytes) noexcept;
    // The increment since the last complete scan; the present value becomes the last. Nothing: this is the
    // first, or the number went back.
    std::optional<std::uint64_t> step() noexcept;
  };
  WrappingCounter clock_, counter_;
  double clock_ns_ = 0;
  std::uint64_t last_sequence_ = 0;  // the last frame's sequence
  DecoderCounts counts_;
  std::optional<Misfit> misfit_;
};

// The id of a board: the board's number shifted left is added. Without board_shift, the id itself.
std::uint32_t with_board_number(std::uint32_t id, const std::optional<unsigned>& board_shift,
                                unsigned board) noexcept;

}  // namespace slipd::decode
