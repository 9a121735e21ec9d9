#include "drivers/push/frame_ring.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <new>

namespace slipd::push {
namespace {

using push_layout::RingHeader;
using push_layout::RingSlot;

// Since Linux 6.3; not in the headers of Debian 12.
constexpr unsigned kRingNoExec = 0x0008U;

// Sealed: it keeps its size.
UniqueFd ring_file(std::size_t bytes) noexcept {
  constexpr const char* kName = "slipd-push";
  UniqueFd file(memfd_create(kName, MFD_CLOEXEC | MFD_ALLOW_SEALING | kRingNoExec));
  if (!file) file = UniqueFd(memfd_create(kName, MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!file || ftruncate(file.get(), static_cast<off_t>(bytes)) != 0 ||
      fcntl(file.get(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0)
    return {};
  return file;
}

}  // namespace

FrameRing::FrameRing(std::size_t values_bytes) noexcept {
  const std::size_t bytes = push_layout::ring_bytes(values_bytes);
  UniqueFd file = ring_file(bytes);
  if (!file) return;
  // Populated: the first frames meet no page fault.
  void* const made = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, file.get(), 0);
  if (made == MAP_FAILED) return;
  memory_ = static_cast<std::byte*>(made);
  values_bytes_ = values_bytes;
  file_ = std::move(file);
  auto* const header = new (memory_) RingHeader;
  header->slot_bytes = push_layout::ring_slot_bytes(values_bytes);
  for (std::uint64_t i = 0; i < push_layout::kRingSlots; ++i) new (&slot(i)) RingSlot;
}

FrameRing::~FrameRing() {
  if (memory_ != nullptr) munmap(memory_, push_layout::ring_bytes(values_bytes_));
}

RingSlot& FrameRing::slot(std::uint64_t frame) const noexcept {
  const std::size_t at =
      sizeof(RingHeader) + frame % push_layout::kRingSlots * push_layout::ring_slot_bytes(values_bytes_);
  return *reinterpret_cast<RingSlot*>(memory_ + at);
}

bool FrameRing::holds(std::uint64_t frame) const noexcept {
  // A read that is a write in form (adding 0). Acquire: pairs with the writer's release of the number, so
  // that values read from here on are of this frame or newer. Release: values read before stay before it, so
  // that the second look sees the number gone if the writer had begun to overwrite one of them: the writer
  // takes the number away before that, by an exchange that acquires, which its writes stay behind.
  return frame != 0 && slot(frame).frame.fetch_add(0, std::memory_order_acq_rel) == frame;
}

const std::uint8_t* FrameRing::values(std::uint64_t frame) const noexcept {
  return reinterpret_cast<const std::uint8_t*>(&slot(frame) + 1);
}

void FrameRing::give_back(std::uint64_t frame) noexcept {
  // Release: pairs with the acquire of `taken` in the writer, whose next values come after these were read.
  std::launder(reinterpret_cast<RingHeader*>(memory_))->taken.store(frame, std::memory_order_release);
}

}  // namespace slipd::push
