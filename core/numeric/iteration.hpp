// When iterations end: what all of them share whose steps gain digits quickly.
#pragma once

namespace slipd {

// Steps at most; it bounds the time of a frame. 5 … 50; usually 2 to 6 are needed. Too small: what is not
// found yet is refused, or off. Too large: the longest frame takes longer.
inline constexpr int kMostSteps = 15;

// An iteration has settled when a step moves its result by less than this share; 1e-6 … 1e-3. Too small:
// single precision never reaches it. Too large: results are off by as much, and what follows the load from
// frame to frame drifts from it.
inline constexpr double kSettled = 1e-5;

}  // namespace slipd
