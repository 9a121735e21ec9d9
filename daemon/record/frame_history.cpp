#include "daemon/record/frame_history.hpp"

#include <algorithm>

namespace slipd {

FrameHistory::FrameHistory(std::size_t taxels, std::size_t frames)
    : memory_(3 * taxels * std::max<std::size_t>(frames, 1)),
      slots_(std::max<std::size_t>(frames, 1)),
      estimates_(slots_.size()) {
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
  estimates_[next_].reset();
  next_ = (next_ + 1) % slots_.size();
  size_ = std::min(size_ + 1, slots_.size());
}

std::size_t FrameHistory::slot_index(std::size_t age_rank) const noexcept {
  return (next_ + slots_.size() - size_ + age_rank) % slots_.size();
}

const FrameSlot& FrameHistory::operator[](std::size_t age_rank) const noexcept {
  return slots_[slot_index(age_rank)];
}

// Searches from the newest: estimates follow their frames closely.
void FrameHistory::attach_estimate(std::int64_t time_ns, const RecordedEstimate& estimate) noexcept {
  for (std::size_t rank = size_; rank > 0; --rank) {
    const std::size_t at = slot_index(rank - 1);
    if (slots_[at].time_ns < time_ns) return;
    if (slots_[at].time_ns > time_ns) continue;
    if (!estimates_[at]) estimates_[at] = estimate;
    return;
  }
}

const RecordedEstimate* FrameHistory::estimate(std::size_t age_rank) const noexcept {
  const auto& estimate = estimates_[slot_index(age_rank)];
  return estimate ? &*estimate : nullptr;
}

std::size_t FrameHistory::bytes_of_frame(std::size_t taxels) noexcept {
  return 3 * taxels * sizeof(float) + sizeof(FrameSlot) + sizeof(std::optional<RecordedEstimate>);
}

}  // namespace slipd
