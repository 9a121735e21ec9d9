// A copy of one sensor's newest frame, made when a client asks for it, so that the estimate thread copies
// frames only on request. One atomic variable, the phase, decides which thread owns the memory.
//
//   io                                 phase       estimate
//   request(taxels)
//     resizes the content              idle        fill_if_requested: false
//     store(requested, release) ----> requested
//   result: null                                   fill_if_requested:
//                                                    load(acquire): sees the resized content
//                                                    copies the frame
//                                     filled <----   store(filled, release), returns true
//   result:                                        fill_if_requested: false
//     load(acquire): sees the frame
//   release                           idle
//
// The content belongs to io in the phases idle and filled, to the estimate thread in requested.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"

namespace slipd {

// Thread-safe between io and the estimate thread.
class FrameCopy {
 public:
  // The copy.
  struct Content {
    // False: no frame has come yet, or it has another number of taxels; nothing below is valid then.
    bool has_frame = false;
    // As in FrameSlot.
    std::uint64_t sequence = 0;
    // As in FrameSlot; ns, CLOCK_MONOTONIC.
    std::int64_t time_ns = 0;
    // Normal pressure of each taxel, Pa.
    std::vector<float> normal_pa;
    // Shear along x of each taxel, Pa.
    std::vector<float> shear_x_pa;
    // Shear along y of each taxel, Pa.
    std::vector<float> shear_y_pa;
  };

  // Called from one thread: io. Allocates for `taxels` and requests a copy. Does nothing if a request is
  // under way. The caller wakes the estimate thread.
  void request(std::size_t taxels);

  // Called from one thread: estimate. Copies `held` if a copy is requested; null: there is no frame. A frame
  // with another number of taxels than requested counts as no frame. Returns true if it did, so that the
  // caller wakes io. Wait-free, allocates nothing.
  bool fill_if_requested(const FrameSlot* held) noexcept;

  // Called from one thread: io. The copy, or null while there is none. Valid until release().
  const Content* result() const noexcept;

  // Called from one thread: io, after it used the result. Another copy can be requested.
  void release() noexcept;

 private:
  enum class Phase : std::uint8_t { idle, requested, filled };
  std::atomic<Phase> phase_{Phase::idle};
  Content content_;
};

}  // namespace slipd
