#include "core/frame/mailbox.hpp"

#include <span>

namespace slipd {

FrameMailbox::FrameMailbox(std::size_t taxels) : memory_(9 * taxels, 0.0F) {
  std::span<float> rest(memory_);
  const auto next = [&] {
    const auto part = rest.first(taxels);
    rest = rest.subspan(taxels);
    return part;
  };
  static_assert(sizeof(FrameMailbox) % kLine == 0, "an object after a mailbox shares no cache line with it");
  for (auto& entry : entries_) {
    FrameSlot& slot = entry.slot;
    slot.normal_pa = next();
    slot.shear_x_pa = next();
    slot.shear_y_pa = next();
  }
}

}  // namespace slipd
