// The board in memory that clients map: estimate threads write each estimate there too, once a client has
// attached. Its layout is board_layout/layout.hpp.
//
// The descriptor that clients get is a memfd sealed with F_SEAL_FUTURE_WRITE. A descriptor that was reopened
// read-only through /proc/self/fd would not do: the file of a memfd has no path and mode 0777, so its
// receiver could open its own /proc/self/fd/N for writing again. Seals belong to the file and hold however it
// is opened: slipd's mapping, made before, stays the only one that can be written, and the size never
// changes, so that no reader gets SIGBUS.
//
// Waiting readers cannot say in read-only memory that they wait. So a client says when it attaches which
// slots it waits for; a slot that nobody waits for costs the writer no system call. An estimate thread wakes
// at most kWokenDirectly readers of a slot, in the order in which they wait; io wakes as many others as
// clients attached. Thus no client makes an estimate thread wake more than that, with however many threads
// it waits.
//
// Each estimate thread writes the slots of its own sensors and grasps (Writer). The heartbeat is that of the
// thread that is furthest behind, so that readers see one that hangs.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "board_layout/layout.hpp"
#include "core/estimate/estimate.hpp"
#include "core/storage/unique_fd.hpp"

namespace slipd {

// Thread-safe between io and estimate threads; each function names its thread.
class SharedBoard {
 public:
  // Readers of a slot that an estimate thread wakes by itself. Fewer: more readers wait for io. More: each
  // costs that thread about a microsecond a frame.
  static constexpr std::uint32_t kWokenDirectly = 4;

  SharedBoard() = default;
  SharedBoard(const SharedBoard&) = delete;
  SharedBoard& operator=(const SharedBoard&) = delete;
  ~SharedBoard();

  // What a client's connection holds while it is attached.
  using Attachment = std::shared_ptr<const void>;

  // Called from one thread: io. Makes the memory, unless it is there; the caller then wakes the estimate
  // threads, which write all records anew. Throws std::system_error, or std::bad_alloc.
  void open(const std::vector<std::string>& sensors, const std::vector<std::string>& grasps);
  // Called from one thread: io, after open. Another descriptor of the memory. Throws std::system_error.
  UniqueFd descriptor() const;
  // Called from one thread: io, after open. One reader more waits for each of these slots until the result is
  // destroyed, in io, which may be after this object.
  Attachment wait_for(const std::vector<std::size_t>& slots);
  // Called from one thread: io, after open.
  std::uint64_t generation() const noexcept;
  std::size_t bytes() const noexcept { return bytes_; }

  // Called from one thread: io, when the IoWakeup was notified. Wakes the readers that estimate
  // threads left.
  void wake_others() noexcept;

  // Called from one thread: io, after the estimate threads have ended or were given up. Tells readers to
  // attach anew.
  void close() noexcept;

  // What an estimate thread writes.
  class Writer;

 private:
  // What readers of a slot do not see. Shared with the attachments.
  struct Use {
    // Readers that wait. Relaxed: no other memory is read because of it; a reader that attaches learns of an
    // estimate published just before from its record.
    std::atomic<std::uint32_t> waiting{0};
    // Readers wait whom the slot's writer did not wake. Relaxed: IoWakeup::notify, which follows, orders
    // it.
    std::atomic<bool> others_due{false};
    // Of the slot's writer: records published.
    std::uint64_t published = 0;
  };

  UniqueFd file_;
  std::size_t bytes_ = 0;
  std::size_t slots_ = 0;
  std::shared_ptr<Use[]> uses_;
  // Release in open, acquire in Writer::begin_round: slots and uses_ are made.
  std::atomic<std::byte*> memory_{nullptr};
  // When each writer began its latest round, ns; 0: it has not seen the memory. Relaxed: independent values.
  std::deque<std::atomic<std::int64_t>> rounds_ns_;
};

// Used by one estimate thread, or by one at a time. No two writers write the same sensor or grasp.
class SharedBoard::Writer {
 public:
  // Called from one thread: io, before estimate threads run. `board` outlives it.
  explicit Writer(SharedBoard& board) : board_(board), round_ns_(board.rounds_ns_.emplace_back(0)) {}

  // Once a round. Whether a client has attached; then it also writes the heartbeat. `is_new`: the memory was
  // made since the last round, and all records of this writer have to be written.
  bool begin_round(std::int64_t now_ns, bool& is_new) noexcept;
  // Writes a record and wakes readers; nothing if no client has attached. True if io has others to wake.
  // Wait-free.
  bool publish_sensor(std::size_t sensor, const Estimate& estimate, bool simulated) noexcept;
  // The same for a grasp. `oldest_ns`: the least Estimate::time_ns of its sensors. `first_sensor`: the index
  // of the sensor that slides first, for Estimate::first_gamma.
  bool publish_grasp(std::size_t grasp, const Estimate& estimate, std::int64_t oldest_ns, bool simulated,
                     std::size_t first_sensor) noexcept;

 private:
  bool publish(std::size_t slot, board_layout::Record& record) noexcept;

  SharedBoard& board_;
  std::atomic<std::int64_t>& round_ns_;
  std::byte* memory_ = nullptr;  // what begin_round saw
};

}  // namespace slipd
