// The loops of alpha_kernels.ipp for x86-64 with AVX2 and FMA; built with flags of its own, see
// CMakeLists.txt.
#include "core/model/alpha_kernels.ipp"

namespace slipd {
extern const AlphaKernels kAlphaKernels_avx2;
const AlphaKernels kAlphaKernels_avx2{"avx2", frame, ratio, angles, project};
}  // namespace slipd
