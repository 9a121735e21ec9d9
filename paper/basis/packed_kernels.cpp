// The loops of packed_kernels.hpp; this file is built once for each instruction set (slipd_instruction_sets).
// As in core/patch/disc_kernels.cpp, no function of the standard library is called.
#include "paper/basis/packed_kernels.hpp"

#include "core/simd/lanes.ipp"

namespace slipd {
namespace {

constexpr std::size_t kStep = PackedKernels::kStep;
constexpr int kPerStep = kStep / kLanes;  // registers

template <int N>
SLIPD_INLINE void project_by(const PackedColumn& x, const float* q, float* z) noexcept {
  Floats even[N] = {}, odd[N] = {};  // so that one addition need not wait for the one before
  const float* value = x.values;
  for (const TaxelRun& run : x.runs) {
    const float* row = q + std::size_t{run.first} * (kLanes * N);
    std::size_t left = run.end - run.first;
    for (; left >= 2; left -= 2, value += 2, row += 2 * kLanes * N) {
      for (int i = 0; i < N; ++i) {
        even[i] += value[0] * load(row + kLanes * static_cast<std::size_t>(i));
        odd[i] += value[1] * load(row + kLanes * static_cast<std::size_t>(N + i));
      }
    }
    if (left == 0) continue;
    for (int i = 0; i < N; ++i) even[i] += value[0] * load(row + kLanes * static_cast<std::size_t>(i));
    ++value;
  }
  for (int i = 0; i < N; ++i) store(z + kLanes * static_cast<std::size_t>(i), even[i] + odd[i]);
}

template <int N>
SLIPD_INLINE void add_by(const PackedColumn& x, const float* z, float* y) noexcept {
  Floats by[N];
  for (int i = 0; i < N; ++i) by[i] = load(z + kLanes * static_cast<std::size_t>(i));
  const float* value = x.values;
  for (const TaxelRun& run : x.runs) {
    float* row = y + std::size_t{run.first} * (kLanes * N);
    for (std::size_t left = run.end - run.first; left > 0; --left, ++value, row += kLanes * N) {
      for (int i = 0; i < N; ++i) {
        float* const at = row + kLanes * static_cast<std::size_t>(i);
        store(at, load(at) + *value * by[i]);
      }
    }
  }
}

void project(const PackedColumn& x, const float* q, std::size_t width, float* z) noexcept {
  if (width == 1 * kStep) return project_by<1 * kPerStep>(x, q, z);
  if (width == 2 * kStep) return project_by<2 * kPerStep>(x, q, z);
  if (width == 3 * kStep) return project_by<3 * kPerStep>(x, q, z);
  project_by<4 * kPerStep>(x, q, z);
}

void add_product(const PackedColumn& x, const float* z, std::size_t width, float* y) noexcept {
  if (width == 1 * kStep) return add_by<1 * kPerStep>(x, z, y);
  if (width == 2 * kStep) return add_by<2 * kPerStep>(x, z, y);
  if (width == 3 * kStep) return add_by<3 * kPerStep>(x, z, y);
  add_by<4 * kPerStep>(x, z, y);
}

constexpr PackedKernels kLoops{SLIPD_INSTRUCTION_SET_NAME, project, add_product};

}  // namespace

const PackedKernels PackedKernels::SLIPD_INSTRUCTION_SET = kLoops;

}  // namespace slipd
