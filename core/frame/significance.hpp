// How far above its own noise something has to be to be there: the same for all that asks, as nothing asks
// for another risk.
#pragma once

namespace slipd {

// Standard deviations of its own noise above which a quantity is told from noise, and by which two have to
// differ to be two; 2 … 5. Gaussian noise passes 3 once in 740 times, and few things are asked of a frame.
// Too small: noise passes for a load, a turn, another shape. Too large: what is light or slow has no answer.
inline constexpr double kClearSigmas = 3;

// The same of what is asked of each taxel, or begins or ends a contact; 3 … 10. Gaussian noise passes 5 once
// in a few million taxels, uniform noise never (its bound is 1.73). Too small: noise is taken for a contact.
// Too large: light contacts are missed.
inline constexpr double kStandsOutSigmas = 5;

}  // namespace slipd
