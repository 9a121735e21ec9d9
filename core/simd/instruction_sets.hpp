// Chooses the loops for this processor at run time. `Kernels` is a struct of function pointers that exists
// once for each instruction set, as Kernels::baseline, avx2 and avx512 (slipd_instruction_sets in
// core/CMakeLists.txt). The files with the loops do not include this header: its inline functions must be
// built for every processor.
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace slipd {

// The kernels that this processor can run, baseline first. Called from any thread. Chosen at the first call:
// resolvers that run at load time crash under ThreadSanitizer.
template <typename Kernels>
std::span<const Kernels* const> kernels_at_hand() noexcept {
  struct Available {
    std::array<const Kernels*, 3> all{&Kernels::baseline};
    std::size_t count = 1;

    Available() noexcept {
#if defined(__x86_64__)
      if (__builtin_cpu_supports("avx2") == 0 || __builtin_cpu_supports("fma") == 0) return;
      all[count++] = &Kernels::avx2;
      if (__builtin_cpu_supports("avx512vl") == 0 || __builtin_cpu_supports("avx512dq") == 0) return;
      all[count++] = &Kernels::avx512;
#endif
    }
  };
  static const Available kAvailable;
  return std::span(kAvailable.all).first(kAvailable.count);
}

// The fastest kernels that this processor can run. Called from any thread.
template <typename Kernels>
const Kernels& best_kernels() noexcept {
  return *kernels_at_hand<Kernels>().back();
}

}  // namespace slipd
