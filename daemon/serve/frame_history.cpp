#include "daemon/serve/frame_history.hpp"

#include <algorithm>

namespace slipd {

FrameHistory::FrameHistory(std::size_t taxels, std::size_t frames)
    : memory_(3 * taxels * std::max<std::size_t>(frames, 1)), slots_(std::max<std::size_t>(frames, 1)) {
  std::span<float> rest(memory_);
  for (FrameSlot& slot : slots_) {
    for (auto* part : {&slot.normal_pa, &slot.shear_x_pa, &slot.shear_y_pa}) {
      *part = rest.first(taxels);
      rest = rest.subspan(taxels);
    }
  }
}

void FrameHistory::push(const FrameSlot& frame) noexcept {
  copy_frame(frame, slots_[next_]);
  next_ = (next_ + 1) % slots_.size();
  size_ = std::min(size_ + 1, slots_.size());
}

const FrameSlot& FrameHistory::operator[](std::size_t age_rank) const noexcept {
  return slots_[(next_ + slots_.size() - size_ + age_rank) % slots_.size()];
}

}  // namespace slipd
