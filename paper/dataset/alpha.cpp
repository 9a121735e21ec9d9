#include "paper/dataset/alpha.hpp"

#include <algorithm>
#include <array>

#include "core/simd/instruction_sets.hpp"
#include "paper/dataset/alpha_kernels.hpp"

namespace slipd {

void alpha_of(std::span<const float> normal_pa, std::span<const float> shear_x_pa,
              std::span<const float> shear_y_pa, const AlphaMask& mask, std::span<float> alpha) noexcept {
  const std::size_t count = alpha.size();
  if (count >= TaxelView::kLanes) {
    const TaxelView view{normal_pa.data(), shear_x_pa.data(), shear_y_pa.data(), nullptr, nullptr, count};
    return best_kernels<AlphaKernels>().frame(view, mask, alpha.data());
  }
  std::array<float, TaxelView::kLanes> normal{}, shear_x{}, shear_y{}, out{};
  std::copy(normal_pa.begin(), normal_pa.end(), normal.begin());
  std::copy(shear_x_pa.begin(), shear_x_pa.end(), shear_x.begin());
  std::copy(shear_y_pa.begin(), shear_y_pa.end(), shear_y.begin());
  best_kernels<AlphaKernels>().frame({normal.data(), shear_x.data(), shear_y.data(), nullptr, nullptr, count},
                                     mask, out.data());
  std::copy_n(out.begin(), count, alpha.begin());
}

void alpha_of_ratio(std::span<const float> ratio, std::span<float> alpha) noexcept {
  const std::size_t count = alpha.size();
  if (count >= TaxelView::kLanes)
    return best_kernels<AlphaKernels>().ratio(ratio.data(), alpha.data(), count);
  std::array<float, TaxelView::kLanes> in{}, out{};
  std::copy(ratio.begin(), ratio.end(), in.begin());
  best_kernels<AlphaKernels>().ratio(in.data(), out.data(), count);
  std::copy_n(out.begin(), count, alpha.begin());
}

}  // namespace slipd
