// One message of a writer → one frame, or why it is none. No socket, no clock. Acquire thread; allocates
// nothing.
#pragma once

#include <cstdint>
#include <span>

#include "drivers/push/agreement.hpp"
#include "drivers/push/frame_ring.hpp"

namespace slipd::push {

// Why a message is no frame.
enum class Refusal : std::uint8_t {
  none,         // it is one
  wrong_size,   // torn, too long, or of another layout
  unknown,      // of another version, or with flags that this slipd does not know
  bad,          // by the writer's own flag
  repeated,     // its sequence does not rise
  too_old,      // its sample, or nobody knows how old it is
  not_ordered,  // its sample is of the future, or before the last one
  not_finite,   // a value is no number, or too large for Pa
  torn          // its values in the ring are not whole
};

// For people, after "the last message ". Constant.
const char* describe(Refusal refusal) noexcept;

class FrameReader {
 public:
  explicit FrameReader(std::int64_t max_age_ns) noexcept : max_age_ns_(max_age_ns) {}

  // A new writer's frames come from here on. Sequence numbers of frames go on rising.
  void begin(const Agreement& agreed) noexcept;

  // `message`: as received, cut to at most one byte more than a frame. `now_ns`: when it was. `waiting`:
  // another message was behind it, so that it is not of "now". Fills `slot`, whose spans have the size of the
  // layout, unless it refuses the message; a refused one may leave values in it.
  Refusal take(std::span<const std::uint8_t> message, std::int64_t now_ns, bool waiting,
               FrameSlot& slot) noexcept;

  // The same of a notice, whose values are in `ring`; their slot is given back.
  Refusal take_from_ring(std::span<const std::uint8_t> message, FrameRing& ring, std::int64_t now_ns,
                         bool waiting, FrameSlot& slot) noexcept;

 private:
  // The head by itself, and the time of its sample.
  Refusal check(const push_layout::FrameHead& head, std::size_t size, std::int64_t now_ns, bool waiting,
                std::int64_t& time_ns) const noexcept;
  // False: they are no numbers.
  bool take_values(const std::uint8_t* values, FrameSlot& slot) const noexcept;
  // The frame is one.
  void keep(const push_layout::FrameHead& head, std::int64_t time_ns, FrameSlot& slot) noexcept;

  std::int64_t max_age_ns_;
  Agreement agreed_;
  bool begun_ = false;               // last_written_ is of this writer
  std::uint64_t last_written_ = 0;   // sequence of the writer's last frame
  std::uint64_t last_sequence_ = 0;  // of the last frame of any writer
  std::int64_t last_time_ns_ = 0;    // of the last frame of any writer
};

}  // namespace slipd::push
