// What holds for each frame that is taken from a program, whatever the program sends.
#pragma once

#include <cmath>
#include <cstdint>

#include "tests/drivers/driver_fixture.hpp"
#include "tests/fuzz/demand.hpp"

namespace slipd::fuzz {

inline constexpr std::size_t kPushedTaxels = 4;
inline constexpr std::int64_t kPushedMaxAgeNs = 100'000'000;
// Between two messages.
inline constexpr std::int64_t kPushedStepNs = 1'000'000;

// The slot that frames are written into.
class PushedFrames {
 public:
  FrameSlot& slot() { return owned_.slot; }

  // The slot holds the next frame: finite numbers, with a rising sequence and time, not older than allowed.
  void demand_next(std::int64_t now_ns) {
    const FrameSlot& taken = owned_.slot;
    for (const float value : owned_.memory) demand(std::isfinite(value));
    demand(taken.sequence > last_ && taken.time_ns > last_ns_);
    demand(taken.time_ns <= now_ns && now_ns - taken.time_ns <= kPushedMaxAgeNs);
    last_ = taken.sequence;
    last_ns_ = taken.time_ns;
  }

 private:
  test::OwnedSlot owned_{kPushedTaxels};
  std::uint64_t last_ = 0;
  std::int64_t last_ns_ = 0;
};

}  // namespace slipd::fuzz
