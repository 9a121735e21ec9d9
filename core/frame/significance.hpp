// Significance thresholds that all rooms share: how far a quantity has to exceed its own noise to be
// detected.
#pragma once

namespace slipd {

// Two quantities count as alike if they differ by less than this many; 1 … 3. Too small: noise is taken for a
// change, a load at its extreme for one that has fallen. Too large: unloading passes for a monotonic load or
// a slide, and taxels that stick draw a plateau of friction down.
inline constexpr double kAlikeSigmas = 2;

// A quantity is detected if it exceeds this many standard deviations of its noise, and two are different if
// they differ by as many; 2 … 5. Gaussian noise exceeds 3 once in 740 frames, on one side. Too small: noise
// passes for a load, a turn, another shape. Too large: what is light or slow has no answer.
inline constexpr double kClearSigmas = 3;

// The same where many taxels are tested in each frame, or a false detection would begin or end a contact; 3
// … 10. Gaussian noise exceeds 5 once in a few million taxels, uniform noise never (its bound is 1.73). Too
// small: noise is taken for a contact. Too large: light contacts are missed.
inline constexpr double kStandsOutSigmas = 5;

// A load shows friction, its direction, a single minimum and what one frame changes if it exceeds this many;
// 5 … 20. Too small: noise shows a friction that no object has or a jump, and a light pull is read as gross
// slip. Too large: friction is learnt late, on few taxels above all, and light contacts are not compared.
inline constexpr double kStrongSigmas = 10;

// Standard deviations below a mean that 95 % of a Gaussian lie above.
inline constexpr double kOneSided95 = 1.645;

}  // namespace slipd
