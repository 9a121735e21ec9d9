#include "daemon/board/frame_copy.hpp"

#include <algorithm>

namespace slipd {

void FrameCopy::request(std::size_t taxels) {
  // Relaxed: only io leaves idle.
  if (turn_.load(std::memory_order_relaxed) != Turn::idle) return;
  content_.normal_pa.resize(taxels);
  content_.shear_x_pa.resize(taxels);
  content_.shear_y_pa.resize(taxels);
  turn_.store(Turn::asked, std::memory_order_release);  // pairs with the acquire in serve: the room is seen
}

bool FrameCopy::serve(const FrameSlot* held) noexcept {
  if (turn_.load(std::memory_order_acquire) != Turn::asked)
    return false;  // pairs with the release in request
  content_.any = held != nullptr && held->normal_pa.size() == content_.normal_pa.size();
  if (content_.any) {
    content_.sequence = held->sequence;
    content_.time_ns = held->time_ns;
    std::copy(held->normal_pa.begin(), held->normal_pa.end(), content_.normal_pa.begin());
    std::copy(held->shear_x_pa.begin(), held->shear_x_pa.end(), content_.shear_x_pa.begin());
    std::copy(held->shear_y_pa.begin(), held->shear_y_pa.end(), content_.shear_y_pa.begin());
  }
  turn_.store(Turn::answered, std::memory_order_release);  // pairs with the acquire in answer
  return true;
}

const FrameCopy::Content* FrameCopy::answer() const noexcept {
  // Pairs with the release in serve: the copy is whole.
  return turn_.load(std::memory_order_acquire) == Turn::answered ? &content_ : nullptr;
}

void FrameCopy::release() noexcept {
  turn_.store(Turn::idle, std::memory_order_relaxed);  // idle is io's own: nobody else reads on its word
}

}  // namespace slipd
