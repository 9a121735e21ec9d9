// A loop that is inlined into one function for each instruction set, for the tables that best_kernels chooses
// from. For loops that call the standard library, which is then inlined for what the function is built for; a
// file that is built once for each set (slipd_instruction_sets) must not call it. kLoop:
// [[gnu::always_inline]], of a task.
#pragma once

namespace slipd {

template <auto kLoop, typename Task>
void on_baseline(const Task& task) noexcept {
  kLoop(task);
}
#if defined(__x86_64__)
template <auto kLoop, typename Task>
[[gnu::target("avx2,fma")]] void on_avx2(const Task& task) noexcept {
  kLoop(task);
}
template <auto kLoop, typename Task>
[[gnu::target("avx512f,avx512vl,avx512dq")]] void on_avx512(const Task& task) noexcept {
  kLoop(task);
}
#endif

}  // namespace slipd
