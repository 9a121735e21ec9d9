// What simulated devices feel.
#pragma once

#include "tests/support/devices/player.hpp"

namespace slipd::devices {

// A pattern in which every taxel, axis and sensor differs, so that a swapped one shows: taxel i of sensor s
// has a normal pressure of 1000 (i + 1) + 100 s Pa, shear x of half that and shear y of minus a quarter. No
// truth: no contact of two bodies looks like it.
std::vector<Contact> pattern(const Sheet& sheet);

}  // namespace slipd::devices
