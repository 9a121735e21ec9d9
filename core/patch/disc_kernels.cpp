// The loops of disc_kernels.hpp; this file is built once for each instruction set (slipd_instruction_sets).
#include "core/patch/disc_kernels.hpp"

#include "core/simd/lanes.ipp"

namespace slipd {
namespace {

using Four = double __attribute__((vector_size(32)));

SLIPD_INLINE float greatest(const Floats& of) noexcept {
  float most = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) most = of[lane] > most ? of[lane] : most;
  return most;
}

SLIPD_INLINE float least_of(const Floats& of) noexcept {
  float least = of[0];
  for (std::size_t lane = 1; lane < kLanes; ++lane) least = of[lane] < least ? of[lane] : least;
  return least;
}

// |value| of each lane: its bits without the sign.
SLIPD_INLINE Floats magnitude(const Floats& of) noexcept {
  return reinterpret_cast<Floats>(reinterpret_cast<Ints>(of) & 0x7FFFFFFF);
}

SLIPD_INLINE std::size_t counted(const Ints& lanes) noexcept {
  std::size_t count = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) count += static_cast<std::size_t>(lanes[lane]);
  return count;
}

NoiseSums noise(const TaxelView& at) noexcept {
  Sums<1> sums;
  Ints below{};
  Floats peak{}, least = Floats{} + __builtin_inff();
  const TaxelRun all{0, static_cast<std::uint32_t>(at.size)};
  for_blocks(
      &all, 1, at.size, [&](std::size_t i, const Ints& mask) __attribute__((always_inline)) {
        const Floats given = load(at.normal_pa + i), p = where(mask, given);
        least = (mask & (given < least)) != 0 ? given : least;
        const Ints under = p < 0;
        const Floats negative = where(under, p);
        sums.part[0] += negative * negative;
        below -= under;
        peak = p > peak ? p : peak;
        sums.next();
      });
  sums.flush();
  return {sums.total(0), counted(below), greatest(peak), least_of(least)};
}

// One more block's pressures and places.
SLIPD_INLINE void add(Sums<4>& sums, const Floats& p, const Floats& x, const Floats& y) noexcept {
  sums.part[0] += p;
  sums.part[1] += p * x;
  sums.part[2] += p * y;
  sums.part[3] += p * (x * x + y * y);
  sums.next();
}

SLIPD_INLINE PlaceSums ended(Sums<4>& sums, std::size_t dead_taxels) noexcept {
  sums.flush();
  return {sums.total(0), sums.total(1), sums.total(2), sums.total(3), dead_taxels};
}

PlaceSums place(const TaxelView& at, float least_pa) noexcept {
  Sums<4> sums;
  const TaxelRun all{0, static_cast<std::uint32_t>(at.size)};
  for_blocks(
      &all, 1, at.size, [&](std::size_t i, const Ints& mask) __attribute__((always_inline)) {
        const Floats given = load(at.normal_pa + i), x = load(at.x_m + i), y = load(at.y_m + i);
        add(sums, where(mask & ~(given < least_pa), given), x, y);
      });
  return ended(sums, 0);
}

PlaceSums weigh(const TaxelView& at, DiscKernels::Runs runs, float x_m, float y_m,
                const DeadTaxelTest& dead_taxel_test) noexcept {
  Sums<4> sums;
  Ints dead_taxels{};
  for_blocks(
      runs.data(), runs.size(), at.size, [&](std::size_t i, const Ints& mask) __attribute__((always_inline)) {
        const Floats p = where(mask, load(at.normal_pa + i)), x = load(at.x_m + i) - x_m,
                     y = load(at.y_m + i) - y_m;
        dead_taxels -= mask & (p < dead_taxel_test.below_pa) & (x * x + y * y < dead_taxel_test.within_m2);
        add(sums, p, x, y);
      });
  return ended(sums, counted(dead_taxels));
}

ForceSums force(const TaxelView& at, DiscKernels::Runs runs, float x_m, float y_m) noexcept {
  Sums<5> sums;
  Floats peak{}, x_extreme{}, y_extreme{};
  for_blocks(
      runs.data(), runs.size(), at.size, [&](std::size_t i, const Ints& mask) __attribute__((always_inline)) {
        const Floats p = where(mask, load(at.normal_pa + i));
        sums.part[0] += p;
        const Floats x = where(mask, load(at.shear_x_pa + i)), y = where(mask, load(at.shear_y_pa + i));
        sums.part[1] += x;
        sums.part[2] += y;
        const Floats rx = load(at.x_m + i) - x_m, ry = load(at.y_m + i) - y_m;
        sums.part[3] += rx * y - ry * x;
        sums.part[4] += where(mask, rx * rx + ry * ry);
        peak = p > peak ? p : peak;
        x_extreme = magnitude(x) > x_extreme ? magnitude(x) : x_extreme;
        y_extreme = magnitude(y) > y_extreme ? magnitude(y) : y_extreme;
        sums.next();
      });
  sums.flush();
  return {sums.total(0), sums.total(1),  sums.total(2),       sums.total(3),
          sums.total(4), greatest(peak), greatest(x_extreme), greatest(y_extreme)};
}

double shear_squares(const TaxelView& at, DiscKernels::Runs runs, const ContactPose& from) noexcept {
  Sums<1> sums;
  for_blocks(
      runs.data(), runs.size(), at.size, [&](std::size_t i, const Ints& mask) __attribute__((always_inline)) {
        const Floats along = where(
            mask, from.direction_x * load(at.shear_x_pa + i) + from.direction_y * load(at.shear_y_pa + i));
        sums.part[0] += along * along;
        sums.next();
      });
  sums.flush();
  return sums.total(0);
}

MomentSums moments(const TaxelView& at, DiscKernels::Runs runs, const ContactPose& from) noexcept {
  Sums<14> sums;
  const float over = 1 / (from.radius_m * from.radius_m);
  for_blocks(
      runs.data(), runs.size(), at.size, [&](std::size_t i, const Ints& mask) __attribute__((always_inline)) {
        const Floats x = load(at.x_m + i) - from.x_m, y = load(at.y_m + i) - from.y_m;
        const Floats x2 = x * x * over, y2 = y * y * over, s = where(mask, x2 + y2), s2 = s * s;
        const Floats p = where(mask, load(at.normal_pa + i));
        const Floats q = where(
            mask, from.direction_x * load(at.shear_x_pa + i) + from.direction_y * load(at.shear_y_pa + i));
        const Floats qs = q * s, ps = p * s;
        sums.part[0] += p;
        sums.part[1] += q;
        sums.part[2] += ps;
        sums.part[3] += qs;
        sums.part[4] += qs * s;
        sums.part[5] += s;
        sums.part[6] += s2;
        sums.part[7] += s2 * s;
        sums.part[8] += s2 * s2;
        sums.part[9] += ps * s;
        sums.part[10] += ps * x;
        sums.part[11] += ps * y;
        sums.part[12] += p * (x2 - y2);
        sums.part[13] += p * (x * y * over);
        sums.next();
      });
  sums.flush();
  return {sums.total(0),  sums.total(1),  sums.total(2),  sums.total(3), sums.total(4),
          sums.total(5),  sums.total(6),  sums.total(7),  sums.total(8), sums.total(9),
          sums.total(10), sums.total(11), sums.total(12), sums.total(13)};
}

void rings(const TaxelView& at, DiscKernels::Runs runs, const ContactPose& from, std::size_t count,
           RingSums* out) noexcept {
  // Neighbours fall into the same ring: four copies keep one's addition from waiting for the last one's.
  constexpr std::size_t kCopies = 4, kMost = 16;
  Four sums[kCopies][kMost] = {};
  const float scale = static_cast<float>(count) / from.radius_m, square = scale * scale;
  const auto last = static_cast<std::int32_t>(count - 1);
  for_blocks(
      runs.data(), runs.size(), at.size, [&](std::size_t i, const Ints& mask) __attribute__((always_inline)) {
        const Floats x = load(at.x_m + i) - from.x_m, y = load(at.y_m + i) - from.y_m;
        const Floats p = load(at.normal_pa + i);
        const Floats q =
            from.direction_x * load(at.shear_x_pa + i) + from.direction_y * load(at.shear_y_pa + i);
        const Floats s = (x * x + y * y) * square;
        alignas(64) float root[kLanes], ps[kLanes], qs[kLanes];
        alignas(64) std::int32_t ring[kLanes];
        __builtin_memcpy(root, &s, sizeof root);
        __builtin_memcpy(ps, &p, sizeof ps);
        __builtin_memcpy(qs, &q, sizeof qs);
#pragma omp simd
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
          const auto index = static_cast<std::int32_t>(__builtin_sqrtf(root[lane]));
          ring[lane] = index < last ? index : last;
        }
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
          if (mask[lane] == 0) continue;
          sums[lane % kCopies][ring[lane]] +=
              Four{static_cast<double>(ps[lane]), static_cast<double>(qs[lane]), 1, 0};
        }
      });
  for (std::size_t r = 0; r < count; ++r) {
    const Four all = (sums[0][r] + sums[1][r]) + (sums[2][r] + sums[3][r]);
    out[r].p += all[0];
    out[r].q += all[1];
    out[r].taxels += all[2];
  }
}

void add_row(const float* values, std::size_t count, float lever, float* sums, float* moments) noexcept {
  const auto add = [&](std::size_t i, const Floats& value) __attribute__((always_inline)) {
    store(sums + i, load(sums + i) + value);
    store(moments + i, load(moments + i) + value * lever);
  };
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) add(i, load(values + i));
  for (; i < count; ++i) {
    sums[i] += values[i];
    moments[i] += values[i] * lever;
  }
}

constexpr DiscKernels kLoops{
    SLIPD_INSTRUCTION_SET_NAME, noise, place, weigh, force, shear_squares, moments, rings, add_row};

}  // namespace

const DiscKernels DiscKernels::SLIPD_INSTRUCTION_SET = kLoops;

}  // namespace slipd
