#include "core/model/alpha_kernels.hpp"

#include <array>

namespace slipd {

extern const AlphaKernels kAlphaKernels_baseline;
#if defined(__x86_64__)
extern const AlphaKernels kAlphaKernels_avx2;
extern const AlphaKernels kAlphaKernels_avx512;
#endif

namespace {

struct Choice {
  std::array<const AlphaKernels*, 3> all{&kAlphaKernels_baseline};
  std::size_t count = 1;

  Choice() noexcept {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2") == 0 || __builtin_cpu_supports("fma") == 0) return;
    all[count++] = &kAlphaKernels_avx2;
    if (__builtin_cpu_supports("avx512vl") == 0 || __builtin_cpu_supports("avx512dq") == 0) return;
    all[count++] = &kAlphaKernels_avx512;
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

const AlphaKernels& alpha_kernels() noexcept {
  return *choice().all[choice().count - 1];
}

std::span<const AlphaKernels* const> all_alpha_kernels() noexcept {
  return std::span(choice().all).first(choice().count);
}

}  // namespace slipd
