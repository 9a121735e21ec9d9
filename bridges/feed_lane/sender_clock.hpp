// When a message was sent, on this computer's clock. The sender's clock has another zero, and each message is
// under way for another time. The shortest time under way of the last seconds counts as none, so what a
// message took longer is its age: one-way delay variation (IETF RFC 3393; the minimum as in the clock filter
// of NTP, RFC 5905 §10). One thread at a time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace slipd::feed {

class SenderClock {
 public:
  // How far back the shortest time is looked for, ns; it is kept for one to two of these. Shorter: a network
  // that delays everything for so long passes for fast. Longer: clocks drift apart (50 ppm: 0.5 ms in 10 s),
  // and a sender's clock that was set back makes frames old for so long.
  static constexpr std::int64_t kWindowNs = 5'000'000'000;

  // Of a message that came at `received_ns`, CLOCK_MONOTONIC: when it was sent, on the same clock; not later
  // than `received_ns`, and later than the one before. `sent_ns`: on the sender's clock, which wraps after
  // `range_ns`; 0: it does not. A message that was under way for half that range longer than others passes
  // for younger.
  std::int64_t when(std::int64_t sent_ns, std::int64_t received_ns, std::int64_t range_ns = 0) noexcept {
    if (received_ns - window_began_ns_ > kWindowNs) {
      before_ns_ = received_ns - window_began_ns_ > 2 * kWindowNs ? kNone : now_ns_;
      now_ns_ = kNone;
      window_began_ns_ = received_ns;
    }
    const std::int64_t shortest_ns = std::min(before_ns_, now_ns_);
    std::int64_t under_way_ns = received_ns - sent_ns;
    if (range_ns > 0 && shortest_ns != kNone)
      under_way_ns = shortest_ns + nearest(under_way_ns - shortest_ns, range_ns);
    now_ns_ = std::min(now_ns_, under_way_ns);
    const std::int64_t was_ns = received_ns - under_way_ns + std::min(before_ns_, now_ns_);
    last_ns_ = std::clamp(was_ns, std::min(last_ns_ + 1, received_ns), received_ns);
    return last_ns_;
  }
  // The sender began anew.
  void reset() noexcept { before_ns_ = now_ns_ = kNone; }

 private:
  // Of what is the same as `ns` modulo `range_ns`, the nearest to 0.
  static std::int64_t nearest(std::int64_t ns, std::int64_t range_ns) noexcept {
    const std::int64_t rest = ns % range_ns;
    return rest > range_ns / 2 ? rest - range_ns : rest < -range_ns / 2 ? rest + range_ns : rest;
  }

  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::max();
  std::int64_t before_ns_ = kNone, now_ns_ = kNone;  // shortest received - sent of two windows
  std::int64_t window_began_ns_ = 0, last_ns_ = 0;
};

}  // namespace slipd::feed
