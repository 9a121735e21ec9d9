// A word that drivers say of their sensor as well; so it stands alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace slipd {

// What the taxels under a skin lie on. half_space: the skin is taken to go on below them. rigid: it is an
// elastic layer, as thick as they are deep, bonded to a rigid base that they are in. pillars: there is no
// skin, each taxel is the tip of a pillar of its own.
enum class SkinBase : std::uint8_t { half_space, rigid, pillars };
// Of `pillars`. With fewer there is nothing to compare; with more, a frame takes too long.
inline constexpr std::size_t kLeastPillars = 4, kMostPillars = 64;

// As the key skin.base has it.
constexpr const char* to_string(SkinBase base) noexcept {
  return base == SkinBase::rigid ? "rigid" : base == SkinBase::pillars ? "pillars" : "half_space";
}
constexpr SkinBase skin_base_of(std::string_view word) noexcept {
  return word == "rigid" ? SkinBase::rigid : word == "pillars" ? SkinBase::pillars : SkinBase::half_space;
}

}  // namespace slipd
