// How long a sensor may be silent, and over how long it is averaged.
#pragma once

namespace slipd {

// After a pause as long as this what came before is forgotten; s, 0.1 … 10: a sensor without a serial number
// may have been exchanged, and of the pause no more counts for following a drift. Too small: lost frames
// blind what looks for movement, and make a check of the zero that a wide contact fails. Too large: a
// movement across the pause counts as one at once, a turn by more than half the angle between two arms
// wrongly, and a quick exchange goes unseen.
inline constexpr double kPause_s = 1;

// Frames are averaged over blocks of this time, of which noise and the course of a pattern are read; a slower
// sensor's block is one frame; s, 0.01 … 0.2. Too small: noise. Too large: slides are seen late, an
// approaching contact counts as noise, and short pauses between grasps are not used.
inline constexpr double kBlock_s = 0.05;

}  // namespace slipd
