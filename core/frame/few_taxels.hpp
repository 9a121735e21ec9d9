// How many taxels are few.
#pragma once

#include <cstddef>

namespace slipd {

// Layouts of at most so many taxels are read as a whole, and over time: no single frame determines their
// margin. Checked with `slipd-lab tradeoff`. Too small: 6 x 6 taxels give margins of their own that mean
// little. Too large: 8 x 8 taxels lose theirs.
inline constexpr std::size_t kFewTaxels = 40;

// Taxels within the contact's disc below which a frame's shape is not used, 4 to 30, and which a plateau of
// friction has at least. Too small: the shape is noise, and chance makes a plateau. Too large: small contacts
// get no margin from their shape, and torque one under heavy loads alone.
inline constexpr std::size_t kFewInside = 12;

// So few taxels can read anything by chance, or be bad (all, of a sensor that has fewer), 2 … 5: more are a
// contact, lose their shear, agree with a zero or contradict it. Too small: bad taxels do. Too large: a
// fingertip is no contact.
inline constexpr std::size_t kBadTaxels = 3;

// Fewer taxels show neither their noise nor the shape of what touches them, 4 … 50. Too small: noise of a few
// taxels scatters, and their offsets pass for a contact. Too large: sensors with other noise in shear are
// misjudged, and a touch of a small array is taken for its zero.
inline constexpr std::size_t kLeastTaxels = 8;

}  // namespace slipd
