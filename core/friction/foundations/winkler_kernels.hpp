// The loops over springs that WinklerFoundations spends its time in. They exist once for each instruction set
// (winkler_kernels.cpp, built several times), chosen when first used. Estimate thread; nothing here
// allocates.
#pragma once

#include <cstddef>
#include <cstdint>

namespace slipd {

// Rows of kBeds values, one for each bed, of which the first `vectors` times kLanes are looked at; one row
// for each spring in `loads`, what it carries over the bed's friction: so a spring's limit is the same in all
// beds, its own normal load. Spring i stands at x = i + 1/2. Each result is that of the same steps in single
// precision for one bed after the other, to the last bit.
struct WinklerKernels {
  static constexpr std::size_t kSprings = 48, kLanes = 16, kBeds = 64;
  const char* name;

  // Loads of spring i grow by slope times grown[i].
  void (*stretch)(float* loads, const float* grown, const float* slope, std::size_t vectors) noexcept;

  // Beds where `which` is -1 carry what bed `from` carries, times their ratio, as far as rest lets them.
  void (*take_over)(float* loads, const float* rest, std::size_t from, const float* ratio,
                    const std::int32_t* which, std::size_t vectors) noexcept;

  // What loads go to: each row's goal is met within `near` > 0, by a shift of less than `far`.
  struct Goal {
    const float* carried;  // a row
    float near, far;
  };
  // Shifts all springs of a bed together, each as far as its limit, rest[i], lets it, until they carry the
  // goal; of the beds where `which` is -1, and not where it is 0. rest[i] >= 0, and 0 from `touching` on.
  void (*settle)(float* loads, const float* rest, std::size_t touching, const Goal& goal,
                 const std::int32_t* which, std::size_t vectors) noexcept;

  // Sums of load, load x^2 and load x^4.
  void (*sums)(const float* loads, float* q, float* q2, float* q4, std::size_t vectors) noexcept;

  static const WinklerKernels baseline, avx2, avx512;  // chosen by best_kernels
};

}  // namespace slipd
