// How an estimate and a grasp look on the socket: the one place that turns them into JSON. io thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/estimate/estimate.hpp"
#include "daemon/rt/clock.hpp"

namespace slipd {

// One estimate as an object, its members in the order in which a person reads them. An unknown number is
// null, never NaN. Before the first frame there is no sample: times and age are null. `truth` is there only
// for a simulated sensor. All but what hangs on the moment is written once: who asks more often than frames
// come gets the same text with another age.
class EstimateText {
 public:
  EstimateText() = default;  // of no estimate
  EstimateText(const Estimate& estimate, const std::string& sensor, bool simulated);

  // Of two estimates that one sensor has published, whether this is the text of that one.
  bool is_of(const Estimate& estimate, bool simulated) const noexcept;

  void append_to(std::string& out, const Now& now) const;

 private:
  std::string text_;  // without the values of time_ns and age_ms
  std::size_t time_at_ = 0, age_at_ = 0;
  std::uint64_t sequence_ = 0;
  std::int64_t time_ns_ = 0, published_ns_ = 0;
  State state_ = State::stale;
  bool simulated_ = false;
};

void append_grasp(std::string& out, const Estimate& together, const std::string& name,
                  const std::vector<std::string>& sensors);

}  // namespace slipd
