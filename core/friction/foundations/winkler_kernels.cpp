// The loops of winkler_kernels.hpp; this file is built once for each instruction set
// (slipd_instruction_sets). No function of the standard library is called here: what is inline there would
// exist once for all files, perhaps for the wrong processor.
#include "core/friction/foundations/winkler_kernels.hpp"

#include "core/simd/lanes.ipp"

namespace slipd {
namespace {

constexpr auto kSprings = WinklerKernels::kSprings, kBeds = WinklerKernels::kBeds;
constexpr auto kStep = WinklerKernels::kLanes;  // of the rows
static_assert(kStep % kLanes == 0);
// Bounds the time of a shift. Too small: beds near gross slip carry less than their goal. Too large: no
// effect seen, as steps end at the tolerance. Checked by tests/core/friction/winkler_foundations_test.cpp.
constexpr int kMaxSteps = 12;
// Difference from the goal at which a shift is settled: relative, and in N; 1e-6 … 1e-3, above 0. Too small:
// single precision never reaches it. Too large: beds drift from the load.
constexpr float kTolerance = 1e-5F, kLeastTolerance = 1e-12F;

SLIPD_INLINE Floats lesser(const Floats& a, const Floats& b) noexcept {
  return b < a ? b : a;
}

SLIPD_INLINE Floats greater(const Floats& a, const Floats& b) noexcept {
  return a < b ? b : a;
}

SLIPD_INLINE Floats magnitude(const Floats& of) noexcept {
  return of < 0 ? -of : of;
}

SLIPD_INLINE bool any(const Ints& mask) noexcept {
  std::int32_t all = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) all |= mask[lane];
  return all != 0;
}

void stretch(float* loads, const float* grown, const float* slope, std::size_t vectors) noexcept {
  for (std::size_t i = 0; i < kSprings; ++i) {
    float* const row = loads + i * kBeds;
    for (std::size_t bed = 0; bed < vectors * kStep; bed += kLanes)
      store(row + bed, load(row + bed) + load(slope + bed) * grown[i]);
  }
}

// Newton's step where the sum over springs bends little, half an interval where it leads out of what is
// known.
SLIPD_INLINE Floats shift_of(const float* loads, const float* rest, std::size_t touching,
                             const Floats& friction, const Floats& goal, Ints open) noexcept {
  Floats low{}, high{}, shift{};
  for (std::size_t i = 0; i < kSprings; ++i) {
    const Floats now = load(loads + i * kBeds), most = friction * rest[i];
    low = lesser(low, -most - now);
    high = greater(high, most - now);
  }
  const Floats near = magnitude(goal) * kTolerance + kLeastTolerance;
  for (int n = 0; n < kMaxSteps; ++n) {
    Floats sum{}, sticking{};
    for (std::size_t i = 0; i < touching; ++i) {
      const Floats t = load(loads + i * kBeds) + shift, most = friction * rest[i];
      sum += lesser(greater(t, -most), most);
      sticking += where(magnitude(t) < most, Floats{} + 1.0F);
    }
    const Floats off = sum - goal;
    open &= ~(magnitude(off) < near);
    if (!any(open)) break;
    low = off < 0 ? shift : low;
    high = off < 0 ? high : shift;
    const Floats newton = sticking > 0 ? shift - off / sticking : low - 1.0F;
    const Floats next = ((newton > low) & (newton < high)) ? newton : 0.5F * (low + high);
    shift = open ? next : shift;
  }
  return shift;
}

void settle(float* loads, const float* rest, std::size_t touching, const float* friction, const float* goal,
            const std::int32_t* which, std::size_t vectors) noexcept {
  for (std::size_t bed = 0; bed < vectors * kStep; bed += kLanes) {
    Ints chosen;
    __builtin_memcpy(&chosen, which + bed, sizeof chosen);
    if (!any(chosen)) continue;
    const Floats mu = load(friction + bed);
    const Floats shift = shift_of(loads + bed, rest, touching, mu, load(goal + bed), chosen);
    for (std::size_t i = 0; i < kSprings; ++i) {
      float* const place = loads + i * kBeds + bed;
      const Floats now = load(place), most = mu * rest[i];
      store(place, chosen ? lesser(greater(now + shift, -most), most) : now);
    }
  }
}

void sums(const float* loads, float* q, float* q2, float* q4, std::size_t vectors) noexcept {
  for (std::size_t bed = 0; bed < vectors * kStep; bed += kLanes) {
    Floats by[3] = {};
    for (std::size_t i = 0; i < kSprings; ++i) {
      const float place = static_cast<float>(i) + 0.5F, square = place * place;
      const Floats now = load(loads + i * kBeds + bed), weighed = now * square;
      by[0] += now;
      by[1] += weighed;
      by[2] += weighed * square;
    }
    store(q + bed, by[0]);
    store(q2 + bed, by[1]);
    store(q4 + bed, by[2]);
  }
}

constexpr WinklerKernels kLoops{SLIPD_INSTRUCTION_SET_NAME, stretch, settle, sums};

}  // namespace

const WinklerKernels WinklerKernels::SLIPD_INSTRUCTION_SET = kLoops;

}  // namespace slipd
