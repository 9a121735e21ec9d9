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

// The largest share of bad taxels that is tolerated; 0.02 … 0.3. Of the contact's force, if neighbours stand
// for them; of the contact's taxels, if all of them read the greatest value; of the sensor's taxels, if they
// read far below the zero. Too small: a frame with a spike gives no margin, quantised values pass for
// saturation, and a bad taxel contradicts a zero. Too large: on few taxels the margin is that of another
// contact, saturation is believed, and a zero that was taken from a small contact is used.
inline constexpr double kBadShare = 0.1;

// The smallest radius, in taxel sides, of a contact that is distinguished from single bad taxels; 1 … 3. Too
// small: small contacts are taken for dead taxels, and those smaller than a taxel for spikes. Too large: bad
// taxels are believed.
inline constexpr double kResolvedSides = 1.5;

// Taxels that stand for all of a large sensor, evenly chosen, where a sum over all would only cost time; 32 …
// 10000. Too small: rows are judged by few values, and fits start far from where they end. More cost time in
// proportion.
inline constexpr std::size_t kSampled = 192;

}  // namespace slipd
