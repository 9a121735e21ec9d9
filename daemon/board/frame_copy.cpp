#include "daemon/board/frame_copy.hpp"

#include <algorithm>

namespace slipd {

void FrameCopy::request(std::size_t taxels) {
  // Relaxed: only io leaves the phase idle.
  if (phase_.load(std::memory_order_relaxed) != Phase::idle) return;
  content_.normal_pa.resize(taxels);
  content_.shear_x_pa.resize(taxels);
  content_.shear_y_pa.resize(taxels);
  phase_.store(Phase::requested,
               std::memory_order_release);  // pairs with fill_if_requested: the memory is seen
}

bool FrameCopy::fill_if_requested(const FrameSlot* held) noexcept {
  if (phase_.load(std::memory_order_acquire) != Phase::requested)
    return false;  // pairs with the release in request
  content_.has_frame = held != nullptr && held->normal_pa.size() == content_.normal_pa.size();
  if (content_.has_frame) {
    content_.sequence = held->sequence;
    content_.time_ns = held->time_ns;
    std::copy(held->normal_pa.begin(), held->normal_pa.end(), content_.normal_pa.begin());
    std::copy(held->shear_x_pa.begin(), held->shear_x_pa.end(), content_.shear_x_pa.begin());
    std::copy(held->shear_y_pa.begin(), held->shear_y_pa.end(), content_.shear_y_pa.begin());
  }
  phase_.store(Phase::filled, std::memory_order_release);  // pairs with the acquire in result
  return true;
}

const FrameCopy::Content* FrameCopy::result() const noexcept {
  // Acquire: pairs with the release in fill_if_requested, so that the copy is whole.
  return phase_.load(std::memory_order_acquire) == Phase::filled ? &content_ : nullptr;
}

void FrameCopy::release() noexcept {
  phase_.store(Phase::idle,
               std::memory_order_relaxed);  // relaxed: only io uses the content until the next request
}

}  // namespace slipd
