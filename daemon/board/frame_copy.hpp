// A copy of one sensor's newest frame, made only when a client asks for it: io asks, the estimate thread
// copies the frame that it holds, io takes it. One word says whose turn it is; the memory belongs to whoever
// that is.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"

namespace slipd {

class FrameCopy {
 public:
  struct Content {
    bool any = false;  // false: no frame has come yet
    std::uint64_t sequence = 0;
    std::int64_t time_ns = 0;
    std::vector<float> normal_pa, shear_x_pa, shear_y_pa;
  };

  // io. Makes room for `taxels` and asks; does nothing if it has asked before.
  void request(std::size_t taxels);

  // Estimate thread. Copies `held` (null: no frame yet) if asked. A frame that no longer fits the room (the
  // device came back with another layout) counts as none. True if it answered, so that io is woken.
  bool serve(const FrameSlot* held) noexcept;

  // io. The answer, once it is there; else null. Valid until release().
  const Content* answer() const noexcept;
  void release() noexcept;

 private:
  enum class Turn : std::uint8_t { idle, asked, answered };
  std::atomic<Turn> turn_{Turn::idle};
  Content content_;
};

}  // namespace slipd
