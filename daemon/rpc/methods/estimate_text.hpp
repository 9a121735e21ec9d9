// Estimates and grasps as JSON on the socket. Called from one thread: io.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/estimate/estimate.hpp"
#include "daemon/rt/clock.hpp"

namespace slipd {

// One estimate as a JSON object. An unknown number is null, never NaN. Before the first frame times and age
// are null. `truth` is present only for a simulated sensor. The text is built once; only time and age are
// inserted later, so that a client that polls faster than frames arrive costs little.
class EstimateText {
 public:
  // No estimate: is_of is false, and append_to must not be called.
  EstimateText() = default;
  EstimateText(const Estimate& estimate, const std::string& sensor, bool simulated);

  // Whether this is the text of that estimate. Both are estimates of the same sensor.
  bool is_of(const Estimate& estimate, bool simulated) const noexcept;

  // Appends the object, with the age at `now`.
  void append_to(std::string& out, const Now& now) const;

 private:
  std::string text_;  // without the values of time_ns and age_ms
  std::size_t time_at_ = 0, age_at_ = 0;
  std::uint64_t sequence_ = 0;
  std::int64_t time_ns_ = 0, published_ns_ = 0;
  State state_ = State::stale;
  bool simulated_ = false;
};

// Appends a grasp as an object.
void append_grasp(std::string& out, const Estimate& together, const std::string& name,
                  const std::vector<std::string>& sensors);

}  // namespace slipd
