// A word that drivers say of their sensor as well; so it stands alone.
#pragma once

#include <cstdint>

namespace slipd {

// What the taxels under a skin lie on. half_space: the skin is taken to go on below them. rigid: it is an
// elastic layer, as thick as they are deep, bonded to a rigid base that they are in.
enum class SkinBase : std::uint8_t { half_space, rigid };

}  // namespace slipd
