// The board's shared memory, mapped read-only. A thread's own; nothing allocates but map().
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "board_layout/layout.hpp"
#include "core/storage/unique_fd.hpp"

namespace slipd::client {

class BoardView {
 public:
  BoardView() = default;
  ~BoardView() { unmap(); }
  BoardView(const BoardView&) = delete;
  BoardView& operator=(const BoardView&) = delete;

  // Maps the descriptor that `attach` passed. Returns why not, for people; empty: it is mapped. Throws
  // std::bad_alloc.
  std::string map(const UniqueFd& file);
  void unmap() noexcept;
  void swap(BoardView& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(bytes_, other.bytes_);
    std::swap(slots_, other.slots_);
  }
  bool mapped() const noexcept { return memory_ != nullptr; }

  // Whether slipd has stopped or taken up another configuration. Acquire: records are final then.
  bool closed() const noexcept { return header().closed.load(std::memory_order_acquire) != 0; }
  // Of the last sign of life, ns, CLOCK_MONOTONIC; 0: none yet.
  std::int64_t heartbeat_ns() const noexcept { return header().heartbeat_ns.load(std::memory_order_relaxed); }
  // Longest time between two signs of life of a running slipd, ns.
  std::int64_t heartbeat_period_ns() const noexcept { return header().heartbeat_period_ns; }

  // Number of slots.
  std::size_t slots() const noexcept { return slots_; }
  // The slot of a sensor, else of a grasp; -1: there is none.
  int find(const char* name) const noexcept;
  // Its name, which ends with a zero.
  const char* name(int slot) const noexcept { return at(slot).name.data(); }
  // The word to wait on. Acquire: pairs with the writer's release, so that the record of this number or a
  // newer one is found afterwards.
  std::uint32_t published(int slot) const noexcept {
    return at(slot).published.load(std::memory_order_acquire);
  }
  // The newest record.
  board_layout::Record record(int slot) const noexcept { return at(slot).latest.load(); }
  // Sleeps until `published` of the slot is no longer `seen`, or until `until_ns`, CLOCK_MONOTONIC. May
  // return early.
  void wait(int slot, std::uint32_t seen, std::int64_t until_ns) const noexcept;

 private:
  const board_layout::Header& header() const noexcept {
    return *reinterpret_cast<const board_layout::Header*>(memory_);
  }
  const board_layout::Slot& at(int slot) const noexcept {
    return reinterpret_cast<const board_layout::Slot*>(memory_ + sizeof(board_layout::Header))[slot];
  }
  const std::byte* memory_ = nullptr;
  std::size_t bytes_ = 0;
  std::size_t slots_ = 0;
};

}  // namespace slipd::client
