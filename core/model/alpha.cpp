#include "core/model/alpha.hpp"

#include <cmath>
#include <numbers>

// Built with -O3 -fno-trapping-math -fno-math-errno (see CMakeLists.txt), so that the loops below become
// vector code.

namespace slipd {
namespace {

#define SLIPD_INLINE [[gnu::always_inline]] inline

// atan(shear / normal) for normal > 0.
SLIPD_INLINE float angle(float shear, float normal) noexcept {
  const float size = std::fabs(shear);
  const bool steep = size > normal;
  const float t = (steep ? normal : size) / (steep ? size : normal);
  const float s = t * t;
  float sum = 0.0028662257F;
  sum = sum * s - 0.0161657367F;
  sum = sum * s + 0.0429096138F;
  sum = sum * s - 0.0752896400F;
  sum = sum * s + 0.1065626393F;
  sum = sum * s - 0.1420889944F;
  sum = sum * s + 0.1999355085F;
  sum = sum * s - 0.3333314528F;
  sum = sum * s + 1.0F;
  const float shallow = sum * t;
  const float turned = steep ? std::numbers::pi_v<float> / 2 - shallow : shallow;
  return std::copysign(turned, shear);
}

struct Taxels {
  const float* normal;
  const float* shear_x;
  const float* shear_y;
  float* alpha;
  std::size_t count;
};

SLIPD_INLINE void frame_loop(const Taxels& of, const AlphaMask& mask) noexcept {
  const float* __restrict normal = of.normal;
  const float* __restrict shear_x = of.shear_x;
  const float* __restrict shear_y = of.shear_y;
  float* __restrict alpha = of.alpha;
  const AlphaMask m = mask;
  for (std::size_t i = 0; i < of.count; ++i) {
    const float value = angle(shear_x[i] * m.along_x + shear_y[i] * m.along_y, normal[i]);
    alpha[i] = normal[i] > m.least_pa && value == value ? value : 0.0F;
  }
}

SLIPD_INLINE void ratio_loop(const float* __restrict ratio, float* __restrict alpha,
                             std::size_t count) noexcept {
  for (std::size_t i = 0; i < count; ++i) alpha[i] = angle(ratio[i], 1.0F);
}

using FrameLoop = void (*)(const Taxels&, const AlphaMask&) noexcept;
using RatioLoop = void (*)(const float*, float*, std::size_t) noexcept;
struct Kernels {
  FrameLoop frame;
  RatioLoop ratio;
};

void frame_anywhere(const Taxels& of, const AlphaMask& mask) noexcept {
  frame_loop(of, mask);
}
void ratio_anywhere(const float* ratio, float* alpha, std::size_t count) noexcept {
  ratio_loop(ratio, alpha, count);
}

#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] void frame_avx2(const Taxels& of, const AlphaMask& mask) noexcept {
  frame_loop(of, mask);
}
[[gnu::target("avx2,fma")]] void ratio_avx2(const float* ratio, float* alpha, std::size_t count) noexcept {
  ratio_loop(ratio, alpha, count);
}
#endif

// Chosen when first used, not by the loader: what the loader would run is not yet instrumented under a
// sanitizer.
Kernels choose() noexcept {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0)
    return {frame_avx2, ratio_avx2};
#endif
  return {frame_anywhere, ratio_anywhere};
}

const Kernels& kernels() noexcept {
  static const Kernels chosen = choose();
  return chosen;
}

}  // namespace

void alpha_of(std::span<const float> normal_pa, std::span<const float> shear_x_pa,
              std::span<const float> shear_y_pa, const AlphaMask& mask, std::span<float> alpha) noexcept {
  kernels().frame({normal_pa.data(), shear_x_pa.data(), shear_y_pa.data(), alpha.data(), alpha.size()}, mask);
}

void alpha_of_ratio(std::span<const float> ratio, std::span<float> alpha) noexcept {
  kernels().ratio(ratio.data(), alpha.data(), alpha.size());
}

}  // namespace slipd
