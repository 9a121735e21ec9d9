// Limits how often an expensive request is granted: a token bucket. Not thread-safe. Called from one thread:
// io.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>

namespace slipd {

class RequestRate {
 public:
  using Clock = std::chrono::steady_clock;

  // `per_second`: requests a second in the long run, above 0. `burst`: requests that are granted at once
  // after a pause, at least 1.
  RequestRate(double per_second, double burst)
      : per_second_(per_second), burst_(burst), tokens_(burst), refilled_(Clock::now()) {}

  // Whether a request is granted at `now`, and counts. Calls must not go back in time.
  bool grant(Clock::time_point now) noexcept {
    tokens_ =
        std::min(burst_, tokens_ + per_second_ * std::chrono::duration<double>(now - refilled_).count());
    refilled_ = now;
    if (tokens_ < 1) return false;
    tokens_ -= 1;
    return true;
  }
  // Takes a grant back, because what was granted was not done.
  void give_back() noexcept { tokens_ += 1; }
  // After a refusal: whole seconds until a request would be granted, at least 1.
  int wait_s() const noexcept {
    return std::max(1, static_cast<int>(std::ceil((1 - tokens_) / per_second_)));
  }

 private:
  double per_second_;
  double burst_;
  double tokens_;
  Clock::time_point refilled_;
};

}  // namespace slipd
