#include "daemon/board/record_tap.hpp"

#include <span>
#include <thread>

namespace slipd {

FrameQueue::FrameQueue(std::size_t taxels, std::size_t frames)
    : memory_(3 * taxels * frames, 0.0F), slots_(frames), free_(frames), filled_(frames) {
  std::span<float> rest(memory_);
  const auto next = [&] {
    const auto part = rest.first(taxels);
    rest = rest.subspan(taxels);
    return part;
  };
  for (std::uint32_t i = 0; i < frames; ++i) {
    slots_[i].normal_pa = next();
    slots_[i].shear_x_pa = next();
    slots_[i].shear_y_pa = next();
    free_.push(i);
  }
}

void FrameQueue::push(const FrameSlot& frame) noexcept {
  std::uint32_t index = 0;
  if (frame.normal_pa.size() != slots_.front().normal_pa.size() || !free_.pop(index)) {
    missed_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  copy_frame(frame, slots_[index]);
  filled_.push(index);
}

const FrameSlot* FrameQueue::front() {
  return filled_.read_available() > 0 ? &slots_[filled_.front()] : nullptr;
}

void FrameQueue::pop() {
  std::uint32_t index = 0;
  if (filled_.pop(index)) free_.push(index);
}

void RecordTap::detach() noexcept {
  queue_.store(nullptr, std::memory_order_seq_cst);
  while (pushing_.load(std::memory_order_seq_cst)) std::this_thread::yield();  // for one push at most
}

}  // namespace slipd
