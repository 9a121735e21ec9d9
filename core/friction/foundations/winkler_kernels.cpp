// The loops of winkler_kernels.hpp; this file is built once for each instruction set
// (slipd_instruction_sets). No function of the standard library is called here: what is inline there would
// exist once for all files, perhaps for the wrong processor.
#include "core/friction/foundations/winkler_kernels.hpp"

#include "core/numeric/iteration.hpp"
#include "core/simd/lanes.ipp"

namespace slipd {
namespace {

constexpr auto kSprings = WinklerKernels::kSprings, kBeds = WinklerKernels::kBeds;
constexpr auto kStep = WinklerKernels::kLanes;  // of the rows
static_assert(kStep % kLanes == 0);
static_assert(kSprings % 2 == 0);

SLIPD_INLINE Floats lesser(const Floats& a, const Floats& b) noexcept {
  return b < a ? b : a;
}

SLIPD_INLINE Floats greater(const Floats& a, const Floats& b) noexcept {
  return a < b ? b : a;
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

SLIPD_INLINE Floats within(const Floats& a, const Floats& most) noexcept {
  return lesser(greater(a, -most), most);
}

void take_over(float* loads, const float* rest, std::size_t from, const float* ratio,
               const std::int32_t* which, std::size_t vectors) noexcept {
  for (std::size_t i = 0; i < kSprings; ++i) {
    float* const row = loads + i * kBeds;
    const float taken = row[from];
    for (std::size_t bed = 0; bed < vectors * kStep; bed += kLanes) {
      Ints chosen;
      __builtin_memcpy(&chosen, which + bed, sizeof chosen);
      store(row + bed, chosen ? within(load(ratio + bed) * taken, Floats{} + rest[i]) : load(row + bed));
    }
  }
}

// What springs of a bed carry after a shift, and how many of them stick. Two springs at a time, so that no
// sum waits for the one before.
struct Carried {
  Floats sum, sticking;
};
SLIPD_INLINE Carried after_shift(const float* loads, const float* rest, std::size_t touching,
                                 const Floats& shift) noexcept {
  Floats sum[2] = {}, sticking[2] = {};
  const Floats one = Floats{} + 1.0F;
  for (std::size_t i = 0; i < touching; i += 2) {
    for (std::size_t k = 0; k < 2; ++k) {
      const Floats most = Floats{} + rest[i + k], to = load(loads + (i + k) * kBeds) + shift;
      sum[k] += within(to, most);
      sticking[k] += where((to < most) & (to > -most), one);
    }
  }
  return {sum[0] + sum[1], sticking[0] + sticking[1]};
}

// Newton's step where the sum over springs bends little, half an interval where it leads out of what is
// known.
SLIPD_INLINE Floats shift_of(const float* loads, const float* rest, std::size_t touching,
                             const Floats& carried, float near, float far, Ints open) noexcept {
  Floats low = Floats{} - far, high = Floats{} + far, shift{};
  for (int n = 0; n < kMostSteps; ++n) {
    const Carried now = after_shift(loads, rest, touching, shift);
    const Floats off = now.sum - carried;
    open &= ~((off < near) & (off > -near));
    if (!any(open)) break;
    low = off < 0 ? shift : low;
    high = off < 0 ? high : shift;
    const Floats newton = now.sticking > 0 ? shift - off / now.sticking : low - 1.0F;
    const Floats next = ((newton > low) & (newton < high)) ? newton : 0.5F * (low + high);
    shift = open ? next : shift;
  }
  return shift;
}

void settle(float* loads, const float* rest, std::size_t touching, const WinklerKernels::Goal& goal,
            const std::int32_t* which, std::size_t vectors) noexcept {
  touching += touching % 2;
  for (std::size_t bed = 0; bed < vectors * kStep; bed += kLanes) {
    Ints chosen;
    __builtin_memcpy(&chosen, which + bed, sizeof chosen);
    if (!any(chosen)) continue;
    const Floats shift =
        shift_of(loads + bed, rest, touching, load(goal.carried + bed), goal.near, goal.far, chosen);
    for (std::size_t i = 0; i < kSprings; ++i) {
      float* const place = loads + i * kBeds + bed;
      const Floats now = load(place);
      store(place, chosen ? within(now + shift, Floats{} + rest[i]) : now);
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

constexpr WinklerKernels kLoops{SLIPD_INSTRUCTION_SET_NAME, stretch, take_over, settle, sums};

}  // namespace

const WinklerKernels WinklerKernels::SLIPD_INSTRUCTION_SET = kLoops;

}  // namespace slipd
