// Frames that a program sends, its "writer". A socket that the driver makes is the device; one writer at a
// time is connected to it.
//
// The socket keeps messages apart (SOCK_SEQPACKET): a frame comes whole or not at all, with one system call
// and one wake, and a writer that dies amid a message leaves no half. Its price is a longest message, of 17
// 700 taxels with three axes. In a stream (SOCK_STREAM) frames of any size would be put together from pieces,
// and after each wrong length the begin of the next one would have to be sought.
//
//   connection -> candidate --- hello agrees ------> writer
//                     |                                |
//                     +-- contradiction: told, closed  +-- end of file: gone
//
// The values of large frames are not in the message but in memory that is shared with the writer (FrameRing),
// which saves a copy. The message is then a notice, so that order, waking, waiting and the writer's death are
// the socket's as before. A writer that has not mapped the memory, or finds it full, sends whole frames.
//
// A writer that has sent nothing for a while (kPatience) loses its place to the next candidate. Without one,
// or with one that sends no frame, read() returns `away`.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/push/agreement.hpp"
#include "drivers/push/frame_reader.hpp"
#include "drivers/push/frame_ring.hpp"
#include "drivers/push/options.hpp"
#include "drivers/push/push_socket.hpp"

namespace slipd::push {

class PushDriver final : public DeviceDriver {
 public:
  // Throws DriverError for options that cannot work.
  explicit PushDriver(const std::vector<SensorSetup>& sensors);

  DeviceInfo open() override;
  ReadResult read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept override;
  void close() noexcept override;
  std::string why_no_frames() const override;

 private:
  // A program at the other end of a connection.
  struct Peer {
    UniqueFd socket;
    std::int64_t heard_ns = 0;  // its last message, or its connection
    bool hung_up = false;       // what it has sent may still be read
  };
  struct Ready {
    bool connection = false, candidate = false, writer = false, hung_up = false;
  };

  Ready wait(std::int64_t give_up_ns) const noexcept;
  void admit() noexcept;
  // Whether frames now are of another kind, so that the device has to be opened again.
  bool hear_candidate() noexcept;
  void accept_candidate(const Agreement& agreed) noexcept;
  // Gives the writer a ring, if its frames are large.
  void tell_accepted() noexcept;
  ReadResult hear_writer(FrameSlot& slot) noexcept;
  bool is_of_another_kind() const noexcept;
  bool is_away() const noexcept;

  const SensorSetup setup_;
  const Options options_;
  const std::int64_t period_ns_;
  const std::int64_t patience_ns_;  // without a message or frame, before a writer counts as silent
  PushSocket socket_;
  Peer candidate_, writer_;
  FrameRing ring_;          // the writer's own: no earlier writer reaches it
  Agreement agreed_;        // with the writer, or without one
  Agreement announced_;     // what open() described
  bool reopening_ = false;  // read() has asked for close() and open(), which keep all connections
  std::vector<std::uint8_t> message_;
  FrameReader reader_;
  std::int64_t frame_ns_ = 0;        // when the last frame came
  std::int64_t admits_from_ns_ = 0;  // when the next connection is looked at
  std::int64_t allowance_ns_ = 0;    // time up to which messages at the largest rate have come
  Refusal last_refusal_ = Refusal::none;
  Text refused_{};  // what the last refused candidate was told; empty: none
};

}  // namespace slipd::push
