// The writer's end of the shared memory that holds the values of large frames; drivers/push/frame_ring.hpp is
// slipd's, and draws how the two meet. One thread's own.
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <cstddef>
#include <cstring>
#include <utility>

#include "core/storage/unique_fd.hpp"
#include "push_layout/layout.hpp"

namespace slipd::client {

class FrameRing {
 public:
  // No memory: put() puts nothing.
  FrameRing() = default;
  // What slipd has given; none if it is not what this program knows: then frames go by the socket.
  FrameRing(const UniqueFd& file, std::size_t values_bytes) noexcept {
    const std::size_t bytes = push_layout::ring_bytes(values_bytes);
    struct stat there {};
    if (!file || fstat(file.get(), &there) != 0 || static_cast<std::size_t>(there.st_size) != bytes) return;
    void* const mapped =
        mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, file.get(), 0);
    if (mapped == MAP_FAILED) return;
    memory_ = static_cast<std::byte*>(mapped);
    values_bytes_ = values_bytes;
    const push_layout::RingHeader& header = *head();
    if (header.magic != push_layout::kRingMagic || header.version != push_layout::kVersion ||
        header.slots != push_layout::kRingSlots ||
        header.slot_bytes != push_layout::ring_slot_bytes(values_bytes))
      FrameRing().swap(*this);
  }
  FrameRing(FrameRing&& other) noexcept { swap(other); }
  FrameRing& operator=(FrameRing&& other) noexcept {
    swap(other);
    return *this;
  }
  ~FrameRing() {
    if (memory_ != nullptr) munmap(memory_, push_layout::ring_bytes(values_bytes_));
  }

  // Copies the values of the next frame. Its number, for the notice; 0: slipd still reads what is there, or
  // there is no ring.
  std::uint64_t put(const float* values) noexcept {
    if (memory_ == nullptr) return 0;
    const std::uint64_t next = put_ + 1;
    // Acquire: pairs with the release in slipd, which has read what is overwritten here.
    if (next > head()->taken.load(std::memory_order_acquire) + push_layout::kRingSlots) return 0;
    auto* const slot = reinterpret_cast<push_layout::RingSlot*>(
        memory_ + sizeof(push_layout::RingHeader) +
        next % push_layout::kRingSlots * push_layout::ring_slot_bytes(values_bytes_));
    // An exchange, because what it acquires the values below stay behind: who sees one of them and looks
    // again finds that the slot's old frame has gone.
    slot->frame.exchange(0, std::memory_order_acq_rel);
    std::memcpy(reinterpret_cast<std::byte*>(slot + 1), values, values_bytes_);
    slot->frame.store(next, std::memory_order_release);  // pairs with the acquire in slipd
    return put_ = next;
  }

  // The notice of the last frame was not sent: its place is free.
  void take_back() noexcept { --put_; }

 private:
  push_layout::RingHeader* head() const noexcept {
    return reinterpret_cast<push_layout::RingHeader*>(memory_);
  }
  void swap(FrameRing& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(values_bytes_, other.values_bytes_);
    std::swap(put_, other.put_);
  }

  std::byte* memory_ = nullptr;
  std::size_t values_bytes_ = 0;
  std::uint64_t put_ = 0;  // number of the last frame
};

}  // namespace slipd::client
