// Chooses the frames that an overloaded estimator gets: every k-th frame, or one in k at random. A pure
// function of the seed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>

#include "core/numeric/random.hpp"

namespace lab {

enum class Skipping : std::uint8_t {
  regular,  // every k-th frame comes
  random,   // each frame comes with a probability of 1/k: the gaps' lengths are geometric
  bursts    // runs of frames that all come, 20 frames long on average, and gaps k - 1 times as long, both
            // geometric: the effect of a scheduler that gives the processor to another process for a while
};
inline constexpr std::size_t kSkippings = 3;
std::string_view name_of(Skipping skipping) noexcept;

// Called for frames 1, 2, … in turn, says whether the frame comes. The first one comes.
std::function<bool(std::uint64_t)> comes(Skipping skipping, unsigned k, slipd::RandomStream random);

}  // namespace lab
