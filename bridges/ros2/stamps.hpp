// One stamp for each sample, on all topics: messages of a sample come on several ways, on which slipd
// converts its time to the system's clock anew each time. One thread at a time.
#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>

namespace slipd::ros2 {

class Stamps {
 public:
  // The stamp of the sample with this number, ns since 1970: `realtime_ns`, or what it was for the sample's
  // first message.
  std::int64_t of(std::uint64_t seq, std::int64_t realtime_ns) noexcept {
    Stamp& kept = kept_[seq % kept_.size()];
    if (kept.seq != seq || std::abs(kept.realtime_ns - realtime_ns) > kSameSampleNs)
      kept = {seq, realtime_ns};
    return kept.realtime_ns;
  }

 private:
  // A restart of slipd, and somebody who sets the clock, are further apart than what conversions differ by.
  static constexpr std::int64_t kSameSampleNs = 5'000'000;
  // More samples than are under way at once.
  static constexpr std::size_t kKept = 64;

  struct Stamp {
    std::uint64_t seq = 0;
    std::int64_t realtime_ns = 0;
  };
  std::array<Stamp, kKept> kept_;
};

}  // namespace slipd::ros2
