// The loops of torque_kernels.hpp; this file is built once for each instruction set
// (slipd_instruction_sets). No function of the standard library is called here: what is inline there would
// exist once for all files, perhaps for the wrong processor.
#include "core/reading/torque/torque_kernels.hpp"

#include "core/simd/lanes.ipp"

namespace slipd {
namespace {

constexpr float kTiny = 1e-30F;  // keeps quotients finite where no taxel counts

SLIPD_INLINE Floats root(const Floats& of) noexcept {
  float values[kLanes];
  __builtin_memcpy(values, &of, sizeof values);
#pragma omp simd
  for (std::size_t lane = 0; lane < kLanes; ++lane) values[lane] = __builtin_sqrtf(values[lane]);
  Floats out;
  __builtin_memcpy(&out, values, sizeof out);
  return out;
}

SLIPD_INLINE std::size_t selected(const Ints& lanes) noexcept {
  std::int32_t count = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) count += lanes[lane];
  return static_cast<std::size_t>(count);
}

RatioSums ratios(const TaxelView& at, TorqueKernels::Runs runs, std::size_t stride, const RatioTest& test,
                 float* pressure_pa, float* ratio) noexcept {
  Sums<1> sums;
  Ints taxels{};
  std::size_t stored = 0;
  for (std::size_t run = 0; run < runs.size(); run += stride) {
    for_blocks(
        runs.data() + run, 1, at.size, [&](std::size_t i, const Ints& mask) __attribute__((always_inline)) {
          const Floats given = load(at.normal_pa + i);
          const Ints counts = mask & (given > test.least_pa);
          const Floats p = where(counts, given), x = load(at.shear_x_pa + i), y = load(at.shear_y_pa + i);
          const Floats squares = x * x + y * y - test.rectified_pa2;
          store(pressure_pa + stored, p);
          store(ratio + stored, where(counts, root(where(squares > 0, squares)) / (p + kTiny)));
          stored += kLanes;
          taxels -= counts;
          sums.part[0] += p;
          sums.next();
        });
  }
  sums.flush();
  return {stored, selected(taxels), sums.total(0)};
}

double below(const float* pressure_pa, const float* ratio, std::size_t stored, float limit) noexcept {
  Sums<1> sums;
  for (std::size_t i = 0; i < stored; i += kLanes) {
    sums.part[0] += where(load(ratio + i) < limit, load(pressure_pa + i));
    sums.next();
  }
  sums.flush();
  return sums.total(0);
}

template <bool kAll>
SLIPD_INLINE PlateauSums over_plateau(const float* pressure_pa, const float* ratio, std::size_t stored,
                                      const PlateauTest& test) noexcept {
  Sums<kAll ? 7 : 2> sums;
  Ints taxels{};
  for (std::size_t i = 0; i < stored; i += kLanes) {
    const Floats p = load(pressure_pa + i), off = load(ratio + i) - test.ratio, square = p * p;
    const Floats spread = test.noise_pa2 + test.gain * square;  // variance times p^2
    const Ints of_plateau = (p > 0) & (off * off * square < test.within * spread);
    const Floats weight = where(of_plateau, square / (spread + kTiny));
    taxels -= of_plateau;
    sums.part[0] += weight;
    sums.part[1] += weight * off;
    if constexpr (kAll) {
      const Floats by_p = weight * p;
      sums.part[2] += root(weight);
      sums.part[3] += where(of_plateau, p);
      sums.part[4] += by_p;
      sums.part[5] += by_p * p;
      sums.part[6] += by_p * off;
    }
    sums.next();
  }
  sums.flush();
  PlateauSums out{.taxels = selected(taxels), .weight = sums.total(0), .off = sums.total(1)};
  if constexpr (kAll) {
    out.width = sums.total(2);
    out.normal_pa = sums.total(3);
    out.p = sums.total(4);
    out.pp = sums.total(5);
    out.p_off = sums.total(6);
  }
  return out;
}

PlateauSums near(const float* pressure_pa, const float* ratio, std::size_t stored,
                 const PlateauTest& test) noexcept {
  return over_plateau<false>(pressure_pa, ratio, stored, test);
}

PlateauSums plateau(const float* pressure_pa, const float* ratio, std::size_t stored,
                    const PlateauTest& test) noexcept {
  return over_plateau<true>(pressure_pa, ratio, stored, test);
}

TorqueSums turning(const TaxelView& at, TorqueKernels::Runs runs, const ContactPose& from,
                   const TorqueMotion& motion) noexcept {
  Sums<9> sums;
  const float scale = 1 / from.radius_m, speed_x = motion.along * from.direction_x,
              speed_y = motion.along * from.direction_y, spin = motion.spin;
  for_blocks(
      runs.data(), runs.size(), at.size, [&](std::size_t i, const Ints& mask) __attribute__((always_inline)) {
        const Floats x = scale * (load(at.x_m + i) - from.x_m), y = scale * (load(at.y_m + i) - from.y_m);
        const Floats v_x = speed_x - spin * y, v_y = speed_y + spin * x;
        const Floats s = x * x + y * y, square = where(mask, v_x * v_x + v_y * v_y);
        const Floats work = where(mask, load(at.shear_x_pa + i) * v_x + load(at.shear_y_pa + i) * v_y);
        const Floats limit = where(mask, load(at.normal_pa + i)) * root(square);
        const Floats weights[3] = {work, limit, square};
        for (std::size_t w = 0; w < 3; ++w) {
          const Floats first = weights[w] * s;
          sums.part[3 * w] += weights[w];
          sums.part[3 * w + 1] += first;
          sums.part[3 * w + 2] += first * s;
        }
        sums.next();
      });
  sums.flush();
  TorqueSums out;
  for (int power = 0; power < 3; ++power) {
    out.work[power] = sums.total(power);
    out.limit[power] = sums.total(3 + power);
    out.speeds[power] = sums.total(6 + power);
  }
  return out;
}

constexpr TorqueKernels kLoops{SLIPD_INSTRUCTION_SET_NAME, ratios, below, near, plateau, turning};

}  // namespace

const TorqueKernels TorqueKernels::SLIPD_INSTRUCTION_SET = kLoops;

}  // namespace slipd
