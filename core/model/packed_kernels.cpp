#include "core/model/packed_kernels.hpp"

#include <array>

namespace slipd {

extern const PackedKernels kPackedKernels_baseline;
#if defined(__x86_64__)
extern const PackedKernels kPackedKernels_avx2;
extern const PackedKernels kPackedKernels_avx512;
#endif

namespace {

struct Choice {
  std::array<const PackedKernels*, 3> all{&kPackedKernels_baseline};
  std::size_t count = 1;

  Choice() noexcept {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2") == 0 || __builtin_cpu_supports("fma") == 0) return;
    all[count++] = &kPackedKernels_avx2;
    if (__builtin_cpu_supports("avx512vl") == 0 || __builtin_cpu_supports("avx512dq") == 0) return;
    all[count++] = &kPackedKernels_avx512;
#endif
  }
};

// Asked when first used, after main began: resolvers that run while the program is loaded crash under
// ThreadSanitizer.
const Choice& choice() noexcept {
  static const Choice kChoice;
  return kChoice;
}

}  // namespace

const PackedKernels& packed_kernels() noexcept {
  return *choice().all[choice().count - 1];
}

std::span<const PackedKernels* const> all_packed_kernels() noexcept {
  return std::span(choice().all).first(choice().count);
}

}  // namespace slipd
