// The loops of alpha_kernels.hpp; this file is built once for each instruction set (slipd_instruction_sets).
// As in core/patch/disc_kernels.cpp, no function of the standard library is called.
#include "paper/dataset/alpha_kernels.hpp"

#include "core/simd/lanes.ipp"

namespace slipd {
namespace {

using Eight = float __attribute__((vector_size(32)));

// atan(shear / normal) for normal > 0: polynomial of docs/methods.md §35, 2e-8.
SLIPD_INLINE Floats angle(const Floats& shear, const Floats& normal) noexcept {
  const Floats size = shear < 0 ? -shear : shear;
  const Ints steep = size > normal;
  const Floats t = (steep ? normal : size) / (steep ? size : normal);
  const Floats s = t * t;
  Floats sum = s * 0.0028662257F - 0.0161657367F;
  sum = sum * s + 0.0429096138F;
  sum = sum * s - 0.0752896400F;
  sum = sum * s + 0.1065626393F;
  sum = sum * s - 0.1420889944F;
  sum = sum * s + 0.1999355085F;
  sum = sum * s - 0.3333314528F;
  sum = sum * s + 1.0F;
  const Floats shallow = sum * t;
  const Floats turned = steep ? 1.5707963267948966F - shallow : shallow;
  return shear < 0 ? -turned : turned;
}

// 0 where the mask leaves it out, and where it is not a number.
SLIPD_INLINE Floats angle_at(const TaxelView& at, std::size_t i, const AlphaMask& mask,
                             const Floats& normal) noexcept {
  const Floats value =
      angle(mask.along_x * load(at.shear_x_pa + i) + mask.along_y * load(at.shear_y_pa + i), normal);
  const Ints number = value == value;  // NOLINT(misc-redundant-expression): false of what is none
  return where((normal > mask.least_pa) & number, value);
}

void frame(const TaxelView& at, const AlphaMask& mask, float* alpha) noexcept {
  const TaxelRun all{0, static_cast<std::uint32_t>(at.size)};
  for_blocks(
      &all, 1, at.size, [&](std::size_t i, const Ints&) __attribute__((always_inline)) {
        store(alpha + i, angle_at(at, i, mask, load(at.normal_pa + i)));
      });
}

void ratio(const float* given, float* alpha, std::size_t count) noexcept {
  const TaxelRun all{0, static_cast<std::uint32_t>(count)};
  for_blocks(
      &all, 1, count, [&](std::size_t i, const Ints&) __attribute__((always_inline)) {
        store(alpha + i, angle(load(given + i), Floats{} + 1.0F));
      });
}

AngleSums angles(const TaxelView& at, AlphaKernels::Runs runs, const AlphaMask& mask, float* alpha) noexcept {
  Sums<2> sums;
  Ints taken{};
  for_blocks(
      runs.data(), runs.size(),
      at.size, [&](std::size_t i, const Ints& of_run) __attribute__((always_inline)) {
        const Floats normal = load(at.normal_pa + i);
        const Floats value = where(of_run, angle_at(at, i, mask, normal));
        const Ints counted = of_run & (normal > mask.least_pa);
        store(alpha + i, of_run ? value : load(alpha + i));
        const Floats over = where(counted, 1 / normal);
        sums.part[0] += value * value;
        sums.part[1] += over * over;
        taken -= counted;
        sums.next();
      });
  sums.flush();
  std::size_t count = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) count += static_cast<std::size_t>(taken[lane]);
  return {sums.total(0), sums.total(1), count};
}

void project(const float* alpha, AlphaKernels::Runs runs, const float* basis, std::size_t stride,
             float* out) noexcept {
  constexpr std::size_t kCopies = 4;  // so that one addition need not wait for the one before
  Eight sums[kCopies] = {};
  const auto add = [&](std::size_t i, std::size_t copy) __attribute__((always_inline)) {
    Eight row;
    __builtin_memcpy(&row, basis + i * stride, sizeof row);
    sums[copy] += alpha[i] * row;
  };
  for (const TaxelRun& run : runs) {
    std::size_t i = run.first;
    for (; i + kCopies <= run.end; i += kCopies) {
      add(i, 0);
      add(i + 1, 1);
      add(i + 2, 2);
      add(i + 3, 3);
    }
    for (; i < run.end; ++i) add(i, 0);
  }
  const Eight all = (sums[0] + sums[1]) + (sums[2] + sums[3]);
  __builtin_memcpy(out, &all, sizeof all);
}

constexpr AlphaKernels kLoops{SLIPD_INSTRUCTION_SET_NAME, frame, ratio, angles, project};

}  // namespace

const AlphaKernels AlphaKernels::SLIPD_INSTRUCTION_SET = kLoops;

}  // namespace slipd
